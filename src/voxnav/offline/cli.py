# SPDX-License-Identifier: BSD-3-Clause
"""``scripts/map_bag``: maps a recording as fast as the machine allows."""

from __future__ import annotations

import argparse
import os
import sys
import time
from typing import Any, Sequence

import numpy as np

import voxnav
from voxnav import files
from voxnav.array_types import Array
from voxnav.offline.bag import Bag
from voxnav.offline.configs import given_mount, load_files, options_of
from voxnav.offline.datasets import ScanFolder
from voxnav.offline.outputs import write_outputs
from voxnav.offline.runner import OfflineMapper
from voxnav.offline.sensors import MountedSensor
from voxnav.recordings.errors import DatasetError
from voxnav.recordings.left_out import REPEATED
from voxnav.recordings.page import page

NOT_COVERED = 3  # exit status of a run whose map does not cover the recording


class ProgressBar:
    """Shows progress as one line on a terminal, or as ten lines if the output is not a terminal."""

    def __init__(self, total: int) -> None:
        self._total, self._started, self._last = max(total, 1), time.monotonic(), -1

    def update(self, done: int) -> None:
        share = min(done / self._total, 1.0)
        step = int(share * (200 if sys.stderr.isatty() else 10))
        if step == self._last:
            return
        self._last = step
        elapsed = time.monotonic() - self._started
        left = elapsed / share - elapsed if share > 0 else float("nan")
        bar = "#" * int(30 * share)
        sys.stderr.write("%s[%-30s] %3d %%  scan %d of %d, %.0f s left%s" % (
            "\r" if sys.stderr.isatty() else "", bar, 100 * share, done, self._total, left,
            "" if sys.stderr.isatty() and share < 1.0 else "\n"))
        sys.stderr.flush()


def arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="map_bag", description=__doc__, epilog="Exit status: 0 when what was mapped "
                                     "covers the recording, 3 when it does not, 1 when nothing could be mapped.")
    parser.add_argument("bag", nargs="*", help="rosbags of one recording with clouds, and odometry and IMU where there "
                                               "are any")
    parser.add_argument("--scans", metavar="DIR", help="instead of bags: folder with scans/%%06d.bin and times.txt")
    parser.add_argument("--poses", metavar="FILE",
                        help="with --scans: TUM poses of the sensor; without: LiDAR odometry")
    parser.add_argument("--cloud", metavar="[NAME=]TOPIC", action="append", help="topic of the clouds of a LiDAR; may "
                        "be given several times: all are mapped, and LiDAR odometry follows the first. A sensor with a "
                        "name may have sections of its own in the configuration, as docs/sensors.md tells")
    parser.add_argument("--depth-camera", metavar="[NAME=]TOPIC", action="append", help="topic of the depth images of "
                        "a camera, with its camera_info beside them; may be given several times")
    parser.add_argument("--mount", metavar="'X Y Z ROLL PITCH YAW'", help="where the LiDAR sits on the body, in metres "
                        "and radians; without: as run/mount_source says, which is as the transforms of the bag do")
    parser.add_argument("--reference", metavar="FILE", help="TUM trajectory to measure errors against")
    parser.add_argument("--config", metavar="YAML", help="over config/map_bag.yaml: one section per part")
    parser.add_argument("--out", metavar="DIR", default="map_bag_out", help="folder for everything that is written")
    args = parser.parse_args(argv)
    if bool(args.bag) == (args.scans is not None):
        parser.error("give either bags or --scans DIR")
    return args


def _dataset(args: argparse.Namespace, configs: dict[str, Any]) -> tuple[ScanFolder | Bag, Array]:
    """Opens the recording. Returns it and T_B_L."""
    T_B_L = given_mount(args.mount, configs["run"])
    if args.scans:
        return ScanFolder(args.scans, args.poses), np.eye(4) if T_B_L is None else T_B_L
    bag = Bag(args.bag, options_of(configs, T_B_L))
    return bag, bag.T_B_L


def _map(dataset: ScanFolder | Bag, mapper: OfflineMapper) -> None:
    """Maps a recording. Raises DatasetError if no scan could be mapped."""
    bar, done = ProgressBar(dataset.num_scans), 0
    for record in dataset:
        mapper.add(record)
        if hasattr(record, "points"):
            done += 1
            bar.update(done)
    mapper.end_input()
    mapper.left_out.take(dataset.left_out)
    for sensor in mapper.sensors:
        sensor.coverage.add_lost(dataset.left_out.count(sensor.what, but=REPEATED))
    mapper.warnings += dataset.warnings
    if not mapper.stamps:
        problems = mapper.left_out.lines() + mapper.warnings
        raise DatasetError("no scan could be mapped: " + "; ".join(problems[:5] or ["the recording is empty"]))
    mapper.finish()


def run(args: argparse.Namespace) -> dict[str, Any]:
    configs = load_files(args.config, args.cloud, args.depth_camera)
    dataset, T_B_L = _dataset(args, configs)
    reference = None
    if args.reference:
        stamps, poses = files.read_tum(args.reference)
        reference = (stamps, poses[:, :3, 3])
    mapper = OfflineMapper(configs, MountedSensor("cloud", T_B_L, dataset.topic), dataset.has_poses, dataset.further)
    if dataset.has_imu:
        mapper.expect_imu()
    mapper.origin_m = dataset.origin_m
    if isinstance(dataset, Bag):
        mapper.page = page(dataset.plan, args.bag)
        print("\n".join(mapper.page), flush=True)
    _map(dataset, mapper)
    title = os.path.basename(os.path.normpath(args.scans or args.bag[0]))
    settings = configs["run"]
    return write_outputs(mapper, args.out, title, settings.safety_distance_m, settings.write_mesh, reference)


def _say(metrics: dict[str, Any]) -> None:
    """Prints the results of a run, with the list of what was left out at the end."""
    for name, stage in sorted(metrics["stages"].items()):
        print("%-20s %6d calls  mean %8.2f ms  p99 %8.2f ms  max %8.2f ms" % (
            name, stage["count"], stage["mean_ms"], stage["p99_ms"], stage["max_ms"]))
    for name, value in sorted(metrics.get("errors", {}).items()):
        print("%s = %.3f" % (name, value))
    warnings = [warning for warning in metrics["warnings"] if warning not in metrics["left_out_lines"]]
    for warning in warnings[:20]:
        print("warning: " + warning)
    if len(warnings) > 20:
        print("... and %d warnings more in metrics.json" % (len(warnings) - 20))


def main(argv: Sequence[str] | None = None) -> int:
    args = arguments(argv)
    try:
        metrics = run(args)
    except (DatasetError, voxnav.ConfigError, ValueError, OSError) as error:
        print("map_bag: %s" % error, file=sys.stderr)
        return 1
    _say(metrics)
    print("%d scans, %d submaps; everything is in %s, begin with report.html or metrics.json" % (
        metrics["counts"]["scans"], metrics["counts"]["submaps"], args.out))
    print(metrics["coverage"]["sentence"])
    print("left out:" if metrics["left_out_lines"] else "left out: nothing")
    for line in metrics["left_out_lines"]:
        print("  " + line)
    return 0 if metrics["coverage"]["is_enough"] else NOT_COVERED
