# SPDX-License-Identifier: BSD-3-Clause
"""The grid of a campaign: which flights there are, and in which order they are flown."""

from __future__ import annotations

import itertools
import math
import re
from typing import Iterator, NamedTuple, Sequence

from voxnav.campaign.errors import CampaignError
from voxnav.campaign.worlds import WorldText, read_world, with_density

MAX_FLIGHTS = 100000


class FlightTask(NamedTuple):
    """Everything that a flight follows from, as text and numbers, so that any machine can fly it.

    speed_mps: horizontal speed limit, or None for that of config/uav_simulator.yaml. config: YAML text over the
    defaults, or "". limit_s: simulated seconds after which the goal is given up. wall_limit_s: seconds of wall time
    after which a flight counts as hung.
    """

    world: WorldText
    seed: int
    speed_mps: float | None
    has_faults: bool
    config: str = ""
    limit_s: float = 300.0
    wall_limit_s: float = 1800.0
    campaign: str = ""  # the campaign that stops its flights by this name

    @property
    def name(self) -> str:
        """A name for files and folders, which is unique in a campaign."""
        speed = "" if self.speed_mps is None else "_%gmps" % self.speed_mps
        return "%s_%gtrees%s_seed%d%s" % (self.world.name, self.world.trees_per_ha, speed, self.seed,
                                          "_faults" if self.has_faults else "")


class Grid(NamedTuple):
    """The axes of a grid. Of the densities and speeds None means that of the world and that of the vehicle."""

    worlds: tuple[WorldText, ...]
    seeds: tuple[int, ...]
    densities_per_ha: tuple[float | None, ...]
    speeds_mps: tuple[float | None, ...]
    faults: tuple[bool, ...]

    @property
    def num_flights(self) -> int:
        return math.prod(len(axis) for axis in self)

    def tasks(self, like: FlightTask) -> Iterator[FlightTask]:
        """Yields every flight once, with the settings of `like`, in an order of which each beginning is balanced.

        Round r pairs the s-th seed with combination s + r of world, density, speed and faults, counted around. So the
        first flights, as many as there are seeds, have different seeds and use all combinations equally often.
        """
        if self.num_flights > MAX_FLIGHTS:
            raise CampaignError("%d flights are more than %d" % (self.num_flights, MAX_FLIGHTS))
        worlds = [with_density(*pair) for pair in itertools.product(self.worlds, self.densities_per_ha)]
        combinations = list(itertools.product(worlds, self.speeds_mps, self.faults))
        for index in range(self.num_flights):
            row, seed = divmod(index, len(self.seeds))
            world, speed_mps, has_faults = combinations[(seed + row) % len(combinations)]
            yield like._replace(world=world, seed=self.seeds[seed], speed_mps=speed_mps, has_faults=has_faults)


def seeds(text: str) -> tuple[int, ...]:
    """Reads seeds such as 1000-1099 or 1,2,7-9. Raises CampaignError."""
    out: list[int] = []
    for part in text.split(","):
        match = re.match(r"^\s*(\d+)\s*(?:-\s*(\d+)\s*)?$", part)
        if not match:
            raise CampaignError("seeds are numbers and ranges such as 1000-1099 or 1,2,7-9, and not '%s'" % text)
        first, last = int(match.group(1)), int(match.group(2) or match.group(1))
        if not first <= last < first + MAX_FLIGHTS:
            raise CampaignError("'%s' is no range of seeds" % part)
        out += range(first, last + 1)
    return _distinct("seed", out)


def numbers(text: str, what: str, least: float) -> tuple[float, ...]:
    """Reads numbers such as 100,300. what: singular of their name; least: smallest number allowed."""
    try:
        out = [float(part) for part in text.split(",")]
    except ValueError as error:
        raise CampaignError("%s: numbers such as 2,4,6 are expected, and not '%s'" % (what, text)) from error
    if not all(math.isfinite(value) and value >= least for value in out):
        raise CampaignError("%s: '%s' holds a number below %g, or none at all" % (what, text, least))
    return _distinct(what, out)


def worlds(text: str) -> tuple[WorldText, ...]:
    """Reads worlds such as forest,meadow or my/world.yaml. Raises CampaignError."""
    out = [read_world(part.strip()) for part in text.split(",")]
    _distinct("world", [world.name for world in out])
    return tuple(out)


def _distinct(what: str, values: Sequence) -> tuple:  # type: ignore[type-arg]
    repeated = sorted({value for value in values if values.count(value) > 1})
    if repeated:
        raise CampaignError("%s %s is given twice" % (what, repeated[0]))
    return tuple(values)
