# SPDX-License-Identifier: BSD-3-Clause
"""``make demo-real`` maps a small recording with the real nodes, and the map is on the true surface."""

import json
import os
import sys

import numpy as np
import pytest

pytest.importorskip("voxnav.simulation")
pytest.importorskip("rosbag")
pytest.importorskip("roslaunch")

import voxnav  # noqa: E402
from recordings import (ABSOLUTE_TIMES, FIRST_STAMP_S, ROOT, TimeField, body_pose, flight,  # noqa: E402
                        sweeps, write_messages)
from running import run_command  # noqa: E402
from voxnav import simulation  # noqa: E402
from voxnav.demo.recording import mount_argument  # noqa: E402
from voxnav.offline.configs import rotation_from_rpy  # noqa: E402

# The sensor is half a metre off the body and rotated about every axis, so that a map without the mount misses the
# surface.
MOUNT = np.eye(4)
MOUNT[:3, :3] = rotation_from_rpy(np.array([0.1, 0.3, 1.2]))
MOUNT[:3, 3] = (0.3, -0.2, 0.4)


@pytest.mark.parametrize("times, first_stamp_s", [(TimeField(), FIRST_STAMP_S), (ABSOLUTE_TIMES, 100.0),
                                                  (ABSOLUTE_TIMES, FIRST_STAMP_S)],
                         ids=["after the stamp", "absolute", "absolute, moved"])
def test_a_recording_with_a_mounted_sensor_is_mapped_where_the_world_is(times, first_stamp_s, tmp_path):
    world, scans = sweeps(MOUNT)
    bag, out = str(tmp_path / "flight.bag"), str(tmp_path / "out")
    write_messages(bag, flight(scans, MOUNT, first_stamp_s=first_stamp_s, times=times))
    command = [sys.executable, os.path.join(ROOT, "scripts", "demo_real"), "--data", bag, "--out", out, "--no-rviz"]
    run = run_command(command)
    with open(os.path.join(out, "roslaunch.log")) as log:
        assert run.returncode == 0, run.stdout + log.read()
    with open(os.path.join(out, "summary.json")) as source:
        summary = json.load(source)
    assert summary["reached"] and summary["reason"] == "%d of %d scans" % (len(scans), len(scans))
    assert os.path.exists(os.path.join(out, "top_view.png"))
    points = voxnav.SubmapCollection.load(os.path.join(out, "map")).occupied_points()
    distances = world.surface_distance(points.astype(np.float64))
    assert len(points) > 100
    assert "point times" in run.stdout and "left out" not in run.stdout
    assert np.mean(distances < 0.2) > 0.95  # 0.2 m is half a voxel
    # All recorded poses are played, including those before the first scan and after the last.
    begin, end = body_pose(0.9)[:3, 3], body_pose(1.2 + 0.1 * len(scans))[:3, 3]
    assert summary["path_length_m"] == pytest.approx(np.linalg.norm(end - begin), abs=0.5)


def map_with_nodes(data, out):
    """Runs demo_real with poses from LiDAR odometry; returns what it printed and its summary."""
    command = [sys.executable, os.path.join(ROOT, "scripts", "demo_real"), "--data", data, "--out", out, "--no-rviz"]
    run = run_command(command)
    with open(os.path.join(out, "summary.json")) as source:
        return run, json.load(source)


def test_a_folder_of_scans_is_mapped_although_nothing_tells_where_down_is(tmp_path):
    scans = sweeps(np.eye(4), 12)[1]
    os.makedirs(str(tmp_path / "scans"))
    for i, scan in enumerate(scans):
        cloud = scan.organised.reshape(-1, 4)
        rows = cloud[np.isfinite(cloud).all(axis=1) & (np.linalg.norm(cloud[:, :3], axis=1) > 0.5)]
        rows.astype("<f4").tofile(str(tmp_path / "scans" / ("%06d.bin" % i)))
    run, summary = map_with_nodes(str(tmp_path), str(tmp_path / "out"))
    assert run.returncode == 0 and summary["reason"] == "12 of 12 scans", run.stdout
    assert summary["stages"]["lidar_odometry/odometry"]["count"] == 12


def test_a_recording_whose_imu_begins_late_is_mapped_once_its_map_is_level(tmp_path):
    scans = sweeps(MOUNT, 45)[1]  # 4.5 s: LiDAR odometry publishes poses after 3 s at the latest
    messages = flight(scans, MOUNT, with_odometry=False, with_imu=True)
    bag = str(tmp_path / "late.bag")
    write_messages(bag, [m for m in messages if m[1] != "/imu" or m[0] > FIRST_STAMP_S + 1.0])
    run, summary = map_with_nodes(bag, str(tmp_path / "out"))
    assert run.returncode == 0 and summary["reason"] == "45 of 45 scans", run.stdout
    assert summary["stages"]["lidar_odometry/odometry"]["count"] == 45
    assert 10 <= summary["stages"]["local_mapper/handover"]["count"] < 45, "the first ones have no poses"


def test_the_mount_is_handed_to_the_launch_file_as_position_and_quaternion():
    values = [float(word) for word in mount_argument(simulation.pose(1.0, 2.0, 3.0, np.pi)).split()]
    assert values == pytest.approx([1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 0.0], abs=1e-6)
    assert mount_argument(None) == mount_argument(np.eye(4)).replace(".000000000", "")
