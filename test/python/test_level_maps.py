# SPDX-License-Identifier: BSD-3-Clause
"""Maps by LiDAR odometry are made of deskewed scans and level in any unit of the IMU, or a warning says why not."""

import json

import numpy as np
import pytest

import voxnav
from voxnav import files
from voxnav.offline.cli import main

pytest.importorskip("voxnav.simulation")
pytest.importorskip("rosbag")

from recordings import (FIRST_STAMP_S, SWEEP_S, body_pose, cloud_message, imu_message, link,  # noqa: E402
                        sweeps, write_messages)

NUM_SCANS = 30
LATER_S = 10000.0  # by how much stamps are later than the time of the flight
TILT_RAD = np.radians(15.0)
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])


def tilted():
    """Returns the mount T_B_L of a sensor that is tilted downwards."""
    T_B_L = np.eye(4)
    T_B_L[:3, :3] = [[np.cos(TILT_RAD), 0, np.sin(TILT_RAD)], [0, 1, 0], [-np.sin(TILT_RAD), 0, np.cos(TILT_RAD)]]
    return T_B_L


@pytest.fixture(scope="module")
def scans():
    return sweeps(tilted(), NUM_SCANS)


def messages_of(scans, first_imu_s=-0.3, unit=1.0, R_I_L=np.eye(3), stray_s=None):
    """Returns messages of scans and of an IMU.

    first_imu_s: the time of the first sample after the first scan; unit: 1 m/s^2 in the unit of the accelerations;
    R_I_L: the rotation from the LiDAR to the IMU; stray_s: by how much the stamp of one sample is ahead.
    """
    import rospy

    is_turned = not np.array_equal(R_I_L, np.eye(3))
    out = []
    if is_turned:
        T_I_L = np.eye(4)
        T_I_L[:3, :3] = R_I_L
        out.append([LATER_S, "/tf_static", link("imu", "lidar", T_I_L)])
    R_I_B = R_I_L @ tilted()[:3, :3].T
    for number, t in enumerate(np.arange(FIRST_STAMP_S + first_imu_s, FIRST_STAMP_S + SWEEP_S * NUM_SCANS, 0.005)):
        msg = imu_message(LATER_S + t)
        for vector, scale in ((msg.angular_velocity, 1.0), (msg.linear_acceleration, unit)):
            vector.x, vector.y, vector.z = scale * R_I_B @ [vector.x, vector.y, vector.z]
        msg.header.frame_id = "imu" if is_turned else "lidar"
        if stray_s is not None and number == 200:
            msg.header.stamp = rospy.Time.from_sec(LATER_S + t + stray_s)
        out.append([LATER_S + t, "/imu", msg])
    for i, scan in enumerate(scans[1]):
        start = LATER_S + FIRST_STAMP_S + SWEEP_S * i
        out.append([start + SWEEP_S + 0.005, "/points", cloud_message(scan, start)])
    return out


@pytest.fixture
def mapped(scans, tmp_path):
    """Returns a function that maps messages_of() and returns the folder of the map and the warnings on the IMU."""

    def run(**imu):
        bag, config, out = str(tmp_path / "flight.bag"), tmp_path / "fine.yaml", tmp_path / "out"
        write_messages(bag, messages_of(scans, **imu))
        config.write_text("map: {resolution_m: 0.2}\nrun: {write_mesh: false, pose_source: lidar}\n")
        assert main([bag, "--config", str(config), "--out", str(out)]) == 0
        warnings = json.loads((out / "metrics.json").read_text())["warnings"]
        return out, [warning for warning in warnings if "IMU" in warning or "down" in warning or "tilted" in warning]

    return run


def tilt_deg(folder, R_B_L):
    """Returns the angle between the true vertical and the z axis of the map.

    R_B_L: the rotation from the LiDAR to the body to which the poses of the trajectory belong.
    """
    stamps, poses = files.read_tum(str(folder / "trajectory_odom.txt"))
    T_W_B = body_pose(stamps[0] - LATER_S + 0.05) @ tilted()
    up_O = poses[0][:3, :3] @ R_B_L @ T_W_B[:3, :3].T @ [0, 0, 1]
    return np.degrees(np.arccos(np.clip(up_O[2], -1.0, 1.0)))


def test_maps_by_lidar_odometry_are_made_of_deskewed_scans(mapped, scans):
    folder, warnings = mapped()
    assert warnings == []
    points = voxnav.SubmapCollection.load(str(folder / "map")).occupied_points().astype(np.float64)
    stamps, poses = files.read_tum(str(folder / "trajectory_odom.txt"))
    # A pose of the trajectory holds for the middle of its sweep.
    T_W_O = body_pose(stamps[0] - LATER_S + 0.05) @ tilted() @ np.linalg.inv(poses[0])
    points = np.ascontiguousarray(points @ T_W_O[:3, :3].T + T_W_O[:3, 3])
    assert np.mean(scans[0].surface_distance(points) < 0.2) > 0.98


@pytest.mark.parametrize("imu", [{"unit": 1.0 / 9.81}, {"unit": 1000.0 / 9.81}, {"first_imu_s": 0.21},
                                 {"first_imu_s": 0.6, "unit": 1.0 / 9.81}, {"R_I_L": UPSIDE_DOWN}],
                         ids=["in g", "in mg", "begins later", "begins much later, in g", "upside down"])
def test_the_map_is_level(imu, mapped):
    folder, warnings = mapped(**imu)
    assert tilt_deg(folder, imu.get("R_I_L", np.eye(3))) < 0.5
    assert warnings == []
    assert len(files.read_tum(str(folder / "trajectory_odom.txt"))[0]) >= NUM_SCANS - 1


@pytest.mark.parametrize("imu, why", [({"first_imu_s": 100.0}, "there is no IMU"), ({"unit": 0.3}, "does not show it")])
def test_a_map_that_is_not_level_comes_with_a_warning(imu, why, mapped):
    folder, warnings = mapped(**imu)
    assert tilt_deg(folder, np.eye(3)) > 10.0
    assert any("nothing tells where down is" in warning and why in warning for warning in warnings)


@pytest.mark.parametrize("stray_s", [0.5, 20.0, 3600.0, -3600.0])
def test_one_sample_with_a_mistaken_stamp_is_left_out_and_counted(stray_s, mapped):
    folder, warnings = mapped(stray_s=stray_s)
    assert tilt_deg(folder, np.eye(3)) < 0.5
    left_out = json.loads((folder / "metrics.json").read_text())["left_out_lines"]
    assert sum(line.startswith("1 x IMU left out") for line in left_out) == 1
    stamps, poses = files.read_tum(str(folder / "trajectory_odom.txt"))
    T_W_O = body_pose(stamps[0] - LATER_S + 0.05) @ tilted() @ np.linalg.inv(poses[0])
    truth = [body_pose(t - LATER_S + 0.05)[:3, 3] for t in stamps]
    errors = [np.linalg.norm((T_W_O @ T)[:3, 3] - p) for T, p in zip(poses, truth)]
    assert max(errors) < 0.15
