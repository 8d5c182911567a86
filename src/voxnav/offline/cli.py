# SPDX-License-Identifier: BSD-3-Clause
"""``scripts/map_bag``: maps a recording as fast as the machine allows."""

from __future__ import annotations

import argparse
import os
import sys
import time
from typing import Any, Sequence

import numpy as np
import yaml

import voxnav
from voxnav import files
from voxnav.array_types import Array, ArrayLike
from voxnav.demo.mission import repository_file
from voxnav.offline.bag import Bag
from voxnav.offline.configs import load_configs
from voxnav.offline.datasets import DatasetError, ScanFolder
from voxnav.offline.outputs import write_outputs
from voxnav.offline.runner import OfflineMapper


class ProgressBar:
    """One line on the terminal; ten lines in all if the output is not a terminal."""

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
    parser = argparse.ArgumentParser(prog="map_bag", description=__doc__)
    parser.add_argument("bag", nargs="?", help="rosbag with clouds, and odometry and IMU where there are any")
    parser.add_argument("--scans", metavar="DIR", help="instead of a bag: folder with scans/%%06d.bin and times.txt")
    parser.add_argument("--poses", metavar="FILE",
                        help="with --scans: TUM poses of the sensor; without: LiDAR odometry")
    parser.add_argument("--reference", metavar="FILE", help="TUM trajectory to measure errors against")
    parser.add_argument("--config", metavar="YAML", help="over config/map_bag.yaml: one section per part")
    parser.add_argument("--out", metavar="DIR", default="map_bag_out", help="folder for everything that is written")
    args = parser.parse_args(argv)
    if (args.bag is None) == (args.scans is None):
        parser.error("give either a bag or --scans DIR")
    return args


def rotation_from_rpy(rpy_rad: ArrayLike) -> Array:
    """Returns the (3, 3) rotation of fixed-axis roll, pitch, yaw."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy_rad), np.sin(rpy_rad)
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                     [-sp, cp * sr, cp * cr]])


def _configs(path: str | None) -> dict[str, Any]:
    with open(repository_file("config/map_bag.yaml")) as source:
        tree = yaml.safe_load(source) or {}
    if path:
        with open(path) as source:
            own = yaml.safe_load(source) or {}
        if not isinstance(own, dict):
            raise voxnav.ConfigError("%s: must be a mapping of sections" % path)
        for section, values in own.items():
            tree[section] = dict(tree.get(section) or {}, **(values or {})) if isinstance(values, dict) else values
    return load_configs(tree)


def _mount(settings: voxnav.OfflineConfig) -> Array | None:
    """Returns T_B_L as configured, or None if it is not configured."""
    if not np.any(settings.mount_position_m) and not np.any(settings.mount_rpy_rad):
        return None
    T_B_L = np.eye(4)
    T_B_L[:3, :3] = rotation_from_rpy(np.array(settings.mount_rpy_rad))
    T_B_L[:3, 3] = settings.mount_position_m
    return T_B_L


def _dataset(args: argparse.Namespace, settings: voxnav.OfflineConfig) -> tuple[ScanFolder | Bag, Array]:
    """Opens the recording. Returns it and T_B_L."""
    T_B_L = _mount(settings)
    if args.scans:
        return ScanFolder(args.scans, args.poses), np.eye(4) if T_B_L is None else T_B_L
    bag = Bag(args.bag, settings.cloud_topic, settings.odometry_topic, settings.imu_topic, T_B_L,
              use_odometry=settings.pose_source != voxnav.PoseSource.LIDAR)
    return bag, bag.T_B_L


def run(args: argparse.Namespace) -> dict[str, Any]:
    configs = _configs(args.config)
    settings = configs["run"]
    dataset, T_B_L = _dataset(args, settings)
    reference = None
    if args.reference:
        stamps, poses = files.read_tum(args.reference)
        reference = (stamps, poses[:, :3, 3])
    mapper = OfflineMapper(configs, T_B_L, dataset.has_poses)
    bar, done = ProgressBar(dataset.num_scans), 0
    for record in dataset:
        mapper.add(record)
        if hasattr(record, "points"):
            done += 1
            bar.update(done)
    if not mapper.stamps:
        raise DatasetError("no scan could be mapped: " + "; ".join(mapper.warnings[:5] or ["the recording is empty"]))
    mapper.finish()
    mapper.warnings += dataset.warnings
    title = os.path.basename(os.path.normpath(args.scans or args.bag))
    return write_outputs(mapper, args.out, title, settings.safety_distance_m, settings.write_mesh, reference)


def main(argv: Sequence[str] | None = None) -> int:
    args = arguments(argv)
    try:
        metrics = run(args)
    except (DatasetError, voxnav.ConfigError, ValueError, OSError) as error:
        print("map_bag: %s" % error, file=sys.stderr)
        return 1
    for name, stage in sorted(metrics["stages"].items()):
        print("%-20s %6d calls  mean %8.2f ms  p99 %8.2f ms  max %8.2f ms" % (
            name, stage["count"], stage["mean_ms"], stage["p99_ms"], stage["max_ms"]))
    for name, value in sorted(metrics.get("errors", {}).items()):
        print("%s = %.3f" % (name, value))
    for warning in metrics["warnings"][:10]:
        print("warning: " + warning)
    print("%d scans, %d submaps; everything is in %s, begin with report.html or metrics.json" % (
        metrics["counts"]["scans"], metrics["counts"]["submaps"], args.out))
    return 0
