# SPDX-License-Identifier: BSD-3-Clause
"""``scripts/campaign``: flies a grid of worlds, seeds, densities, speeds and faults in parallel, and reports it."""

from __future__ import annotations

import argparse
import itertools
import os
import sys
from typing import Any, Sequence

import yaml

from voxnav.campaign import grid
from voxnav.campaign.errors import CampaignError
from voxnav.campaign.flight import fly
from voxnav.campaign.folder import CampaignFolder
from voxnav.campaign.grid import FlightTask, Grid
from voxnav.campaign.progress import say
from voxnav.campaign.report import summary_lines
from voxnav.campaign.rows import FlightRow
from voxnav.campaign.runner import Fly, client, sensible_workers
from voxnav.campaign.search import Values, merged, read_space, score, search, trial_folder
from voxnav.demo.processes import end_cleanly_when_terminated

FAILED = 3  # exit status of a campaign that was flown and in which a flight failed
INTERRUPTED = 130
_FAULTS = {"on": True, "off": False}


def arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="campaign", description=__doc__, epilog="A campaign that was interrupted "
                                     "goes on when the same command is given again. Exit status: 0 when every flight "
                                     "reached its goal without a collision, 3 when one did not, 1 when nothing could "
                                     "be flown, 130 when interrupted.")
    parser.add_argument("--worlds", default="forest", help="names of files in worlds/, or paths; default: %(default)s")
    parser.add_argument("--seeds", required=True, help="of world and sensors, such as 1000-1099 or 1,2,7-9")
    parser.add_argument("--densities", help="trees per hectare, such as 100,300; default: those of the world")
    parser.add_argument("--speeds", help="horizontal speed limits in m/s, such as 2,4,6; default: as configured")
    parser.add_argument("--faults", choices=["on", "off", "both"], default="off", help="default: %(default)s")
    parser.add_argument("--flights", type=int, metavar="N", help="only the first N of the grid, in balanced order")
    parser.add_argument("--config", metavar="YAML", help="over the defaults of config/, one section per node")
    parser.add_argument("--limit", type=float, default=300.0, metavar="S",
                        help="simulated seconds after which a goal is given up; default: %(default)g")
    parser.add_argument("--wall-limit", type=float, default=1800.0, metavar="S",
                        help="seconds of wall time after which a flight counts as hung; default: %(default)g")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder for flights.csv and report.html")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a running Dask scheduler, such as tcp://host:8786")
    parser.add_argument("--workers", type=int, default=sensible_workers(), metavar="N",
                        help="flights at a time without --scheduler; default here: %(default)d")
    parser.add_argument("--search", metavar="YAML", help="search parameters in this space (docs/campaign.md)")
    parser.add_argument("--trials", type=int, default=20, metavar="N", help="of --search; default: %(default)d")
    args = parser.parse_args(argv)
    for name in ("flights", "workers", "trials", "limit", "wall_limit"):
        if getattr(args, name) is not None and not getattr(args, name) > 0:
            parser.error("--%s must be above 0" % name.replace("_", "-"))
    return args


def _config(path: str | None) -> str:
    if path is None:
        return ""
    try:
        with open(path) as source:
            text = source.read()
        if not isinstance(yaml.safe_load(text), dict):
            raise CampaignError("%s: one section per node is expected" % path)
        return text
    except (OSError, yaml.YAMLError) as error:
        raise CampaignError("%s cannot be read: %s" % (path, error)) from error


def _grid(args: argparse.Namespace) -> Grid:
    return Grid(
        grid.worlds(args.worlds), grid.seeds(args.seeds),
        (None,) if args.densities is None else grid.numbers(args.densities, "density", 0.0),
        (None,) if args.speeds is None else grid.numbers(args.speeds, "speed", 0.1),
        (False, True) if args.faults not in _FAULTS else (_FAULTS[args.faults],))


def _tasks(args: argparse.Namespace) -> list[FlightTask]:
    flown = _grid(args)
    like = FlightTask(flown.worlds[0], 0, None, False, _config(args.config), args.limit, args.wall_limit)
    return list(itertools.islice(flown.tasks(like), args.flights))


def _campaign(args: argparse.Namespace, tasks: list[FlightTask], dask: Any, fly_one: Fly) -> list[FlightRow]:
    return CampaignFolder(args.out, tasks[0]).fly(dask, tasks, fly_one)


def _search(args: argparse.Namespace, tasks: list[FlightTask], dask: Any, fly_one: Fly) -> None:
    space, base = read_space(args.search), tasks[0].config

    def measure(values: Values) -> float:
        with_values = [task._replace(config=merged(base, values)) for task in tasks]
        folder = CampaignFolder(os.path.join(args.out, "trials", trial_folder(values)), with_values[0])
        return score(folder.fly(dask, with_values, fly_one), space.min_clearance_m)
    best = search(args.out, space, args.trials, measure)
    path = os.path.join(args.out, "best.yaml")
    with open(path, "w") as out:
        out.write(merged(base, best))
    say("the best configuration is in %s, its flights in %s" % (
        path, os.path.join(args.out, "trials", trial_folder(best))))


def main(argv: Sequence[str] | None = None, fly_one: Fly = fly) -> int:
    args = arguments(argv)
    end_cleanly_when_terminated()
    try:
        tasks = _tasks(args)
        say("campaign: %d flights; results in %s" % (len(tasks), args.out))
        with client(args.scheduler, args.workers) as dask:
            if args.search:
                _search(args, tasks, dask, fly_one)
                return 0
            rows = _campaign(args, tasks, dask, fly_one)
    except (CampaignError, OSError) as error:
        print("campaign: %s" % error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("campaign: interrupted; the same command goes on with it", file=sys.stderr)
        return INTERRUPTED
    for line in summary_lines(rows):
        say(line)
    say("report: %s" % os.path.join(args.out, "report.html"))
    return 0 if all(row.is_success for row in rows) else FAILED
