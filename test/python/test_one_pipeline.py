# SPDX-License-Identifier: BSD-3-Clause
"""The nodes in lock-step and scripts/map_bag make the same trajectory and map of a recording, byte for byte."""

import os
import sys

import pytest

pytest.importorskip("voxnav.simulation")
pytest.importorskip("rosbag")
pytest.importorskip("roslaunch")

from recordings import ROOT, sweeps, write_bag  # noqa: E402
from running import run_command  # noqa: E402
from voxnav.offline.cli import main as map_bag  # noqa: E402

NUM_SCANS = 36
# Open beams are enabled, and submaps close during the flight, so that both are part of the comparison.
NODES = """
cloud_filter: {open_beams: {is_enabled: true}}
local_mapper:
  map: {no_return_range_m: 8.0}
  submap: {period_s: 0.9, min_period_s: 0.5}
"""
OFFLINE = """
run: {pose_source: %s}
open_beams: {is_enabled: true}
map: {no_return_range_m: 8.0}
schedule: {period_s: 0.9, min_period_s: 0.5}
"""


def write(path, text):
    path.write_text(text)
    return str(path)


def through_the_nodes(bag, config, out, *options):
    command = [sys.executable, os.path.join(ROOT, "scripts", "demo_real"), "--data", bag, "--out", out, "--no-rviz",
               "--config", config] + list(options)
    run = run_command(command)
    with open(os.path.join(out, "roslaunch.log")) as log:
        assert run.returncode == 0, run.stdout + log.read()


def content(directory):
    """Returns the bytes of every file of a map, by name."""
    out = {}
    for folder, _, names in os.walk(directory):
        for name in names:
            with open(os.path.join(folder, name), "rb") as source:
                out[os.path.relpath(os.path.join(folder, name), directory)] = source.read()
    return out


@pytest.mark.parametrize("poses", ["odometry", "lidar"])
def test_nodes_and_map_bag_make_the_same_map(poses, tmp_path):
    bag = str(tmp_path / "flight.bag")
    write_bag(bag, sweeps(num_scans=NUM_SCANS)[1], first_stamp_s=100.0,
              with_odometry=poses == "odometry", with_imu=poses == "lidar")
    through_the_nodes(bag, write(tmp_path / "nodes.yaml", NODES), str(tmp_path / "nodes"))
    offline = write(tmp_path / "offline.yaml", OFFLINE % ("recording" if poses == "odometry" else "lidar"))
    assert map_bag([bag, "--config", offline, "--out", str(tmp_path / "offline")]) == 0
    trajectories = [(tmp_path / name / "trajectory.txt").read_text() for name in ("nodes", "offline")]
    assert len(trajectories[0].splitlines()) > NUM_SCANS - 4
    assert trajectories[0] == trajectories[1]
    maps = [content(str(tmp_path / name / "map")) for name in ("nodes", "offline")]
    assert len(maps[0]) > 3 and sorted(maps[0]) == sorted(maps[1])
    assert [name for name in maps[0] if maps[0][name] != maps[1][name]] == []
