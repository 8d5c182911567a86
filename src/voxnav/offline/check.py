# SPDX-License-Identifier: BSD-3-Clause
"""``scripts/check_recording``: prints within seconds what is in a recording and how voxnav will use it."""

from __future__ import annotations

import argparse
import sys
from typing import Sequence

import voxnav
from voxnav.offline.configs import given_mount, load_files, options_of
from voxnav.recordings.bag_files import BagFiles
from voxnav.recordings.errors import DatasetError
from voxnav.recordings.page import page
from voxnav.recordings.plan import RecordingPlan
from voxnav.recordings.problems import problems_of


def arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="check_recording", description=__doc__, epilog="Exit status: 0 without "
                                     "problems, 3 with some, 1 when nothing can be mapped.")
    parser.add_argument("bag", nargs="+", help="rosbags of one recording")
    parser.add_argument("--cloud", metavar="[NAME=]TOPIC", action="append", help="as for map_bag")
    parser.add_argument("--depth-camera", metavar="[NAME=]TOPIC", action="append", help="as for map_bag")
    parser.add_argument("--mount", metavar="'X Y Z ROLL PITCH YAW'", help="where the LiDAR sits on the body, in metres "
                        "and radians; without: as the configuration or the transforms of the bag say")
    parser.add_argument("--config", metavar="YAML", help="as for map_bag")
    return parser.parse_args(argv)


def main(argv: Sequence[str] | None = None) -> int:
    args = arguments(argv)
    try:
        configs = load_files(args.config, args.cloud, args.depth_camera)
        files = BagFiles(args.bag)
        try:
            plan = RecordingPlan(files, options_of(configs, given_mount(args.mount, configs["run"])))
            print("\n".join(page(plan, args.bag)))
        finally:
            files.close()
    except (DatasetError, voxnav.ConfigError, ValueError, OSError) as error:
        print("check_recording: %s" % error, file=sys.stderr)
        return 1
    if plan.error is not None:
        return 1
    return 3 if problems_of(plan) else 0
