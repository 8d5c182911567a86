# SPDX-License-Identifier: BSD-3-Clause
"""``make demo-real``: a recording through the nodes, from nothing to a summary and pictures."""

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
from voxnav.demo import processes, summary
from voxnav.demo.mission import repository_file
from voxnav.demo.record import FlightRecord
from voxnav.demo.rviz import Rviz, show
from voxnav.offline.cli import ProgressBar
from voxnav.offline.configs import mount_from_words
from voxnav.offline.datasets import ScanFolder
from voxnav.recordings.errors import DatasetError
from voxnav.recordings.page import page
from voxnav.recordings.plan import BagOptions


def arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="demo_real", description=__doc__)
    parser.add_argument("--data", required=True, nargs="+",
                        help="rosbags of one recording, or a folder with scans/%%06d.bin and times.txt")
    parser.add_argument("--mount", metavar="'X Y Z ROLL PITCH YAW'", help="where the LiDAR sits on the body, in metres "
                        "and radians; without: as the transforms of the bag say")
    parser.add_argument("--poses", help="TUM poses of the sensor to map with; without: LiDAR odometry, or the bag's")
    parser.add_argument("--reference", help="TUM trajectory to measure against; default: poses_gt.txt in the folder")
    parser.add_argument("--config", help="YAML with one section per node, over the defaults of config/")
    parser.add_argument("--out", default="build/demo_real", help="folder for summary.json and the pictures")
    parser.add_argument("--no-rviz", action="store_true", help="no rviz picture")
    return parser.parse_args(argv)


def _dataset(args: argparse.Namespace) -> tuple[Any, bool, Array | None]:
    """Returns (dataset, whether it has poses, T_B_L or None)."""
    T_B_L = mount_from_words(args.mount) if args.mount else None
    if os.path.isdir(args.data[0]):
        return ScanFolder(args.data[0], args.poses), args.poses is not None, T_B_L
    from voxnav.offline.bag import Bag

    bag = Bag(args.data, BagOptions(T_B_L=T_B_L))
    print("\n".join(page(bag.plan, args.data)), flush=True)
    return bag, bag.has_poses, bag.T_B_L


def _reference(args: argparse.Namespace) -> tuple[Array, Array] | None:
    path = args.reference or os.path.join(args.data[0], "poses_gt.txt")
    if not os.path.exists(path):
        if args.reference:
            raise DatasetError("%s: no such file" % path)
        return None
    stamps, poses = files.read_tum(path)
    return stamps, poses[:, :3, 3]


def mount_argument(T_B_L: Array | None) -> str:
    """Returns the launch argument sensor_mount: x y z qx qy qz qw of T_B_L (4, 4); None is the identity."""
    if T_B_L is None:
        return "0 0 0 0 0 0 1"
    return " ".join("%.17g" % value for value in (*T_B_L[:3, 3], *voxnav.quaternion_of(np.ascontiguousarray(T_B_L))))


def main(argv: Sequence[str] | None = None) -> int:
    args = arguments(argv)
    os.environ["ROS_NAMESPACE"] = "/uav1"  # rospy reads it when imported, which opening a bag does
    os.makedirs(args.out, exist_ok=True)
    name = os.path.basename(os.path.normpath(args.data[0]))
    record = FlightRecord(name)
    started, log = time.monotonic(), os.path.join(args.out, "roslaunch.log")
    try:
        dataset, has_poses, T_B_L = _dataset(args)
        reference = _reference(args)
    except (DatasetError, ValueError, OSError) as error:
        print("demo_real: %s" % error, file=sys.stderr)
        return 1
    print("demo_real: %s through the nodes, poses from %s; logs in %s" % (
        " ".join(args.data), "the recording" if has_poses else "LiDAR odometry", log), flush=True)
    rviz = None
    processes.end_cleanly_when_terminated()
    launch_args = {"odometry": "external" if has_poses else "lidar", "sensor_mount": mount_argument(T_B_L),
                   "pose_source": "odometry", "lockstep": "true",  # the player waits for the nodes
                   "custom_config": os.path.abspath(args.config) if args.config else ""}
    launched, env = processes.launch("bag.launch", launch_args, log)
    try:
        os.environ.update(ROS_MASTER_URI=env["ROS_MASTER_URI"], ROS_IP=env["ROS_IP"])
        from voxnav.nodes import mapping_mission  # not before: it imports rospy

        config = repository_file("rviz/mapping.rviz")
        # rviz starts before the recording is played: messages that it has not received by the end are never sent again.
        if not args.no_rviz:
            rviz = Rviz(env, config, os.path.join(args.out, "rviz.log"))
        bar = ProgressBar(dataset.num_scans)
        mapping_mission.run(record, dataset, has_poses, T_B_L, reference, bar.update, os.path.join(args.out, "map"))
        notes = dataset.warnings[:10] + dataset.left_out.lines()[:10] + show(args, env, record, rviz, config)
    finally:
        if rviz:
            rviz.stop()
        launched.stop()
    result = summary.summarise(record)
    summary.write_json(os.path.join(args.out, "summary.json"), result)
    files.write_tum(os.path.join(args.out, "trajectory.txt"), record.optimised[0], record.optimised_poses)
    print(summary.table(result, "recording mapped"))
    for note in notes:
        print("note: " + note)
    print("\npictures and summary.json in %s (%.0f s)" % (args.out, time.monotonic() - started))
    return 0 if record.reached else 1
