# SPDX-License-Identifier: BSD-3-Clause
"""LidarOdometry, through Python, matches the reference poses of real recordings and survives bad input."""
import os
import re

import numpy as np
import pytest

import voxnav
from voxnav.files import quaternion_from_rotation, rotation_from_quaternion

DATA = os.environ.get("VOXNAV_DATA", os.path.join(os.path.dirname(__file__), "..", "..", "..", "shared", "data"))


def data_path(*parts):
    path = os.path.join(DATA, *parts)
    if not os.path.exists(path):
        pytest.skip("needs the recording %s (set VOXNAV_DATA)" % path)
    return path


def load_scan(folder, number):
    return np.fromfile(data_path(folder, "scans", "%06d.bin" % number), np.float32).reshape(-1, 4)


def to_matrix(position, q_xyzw):
    pose = np.eye(4)
    pose[:3, :3] = rotation_from_quaternion(q_xyzw)
    pose[:3, 3] = position
    return pose


def pose_error(estimate, truth):
    delta = np.linalg.inv(truth) @ estimate
    q_xyzw = np.asarray(quaternion_from_rotation(delta[:3, :3]))
    return np.linalg.norm(delta[:3, 3]), np.degrees(2.0 * np.arctan2(np.linalg.norm(q_xyzw[:3]), abs(q_xyzw[3])))


def sloam_poses():
    with open(data_path("sloam_forest_uav", "poses.txt")) as f:
        blocks = f.read().split("header:")[1:]
    number = r"(-?[\d.]+(?:e-?\d+)?)\s+"
    out = []
    for block in blocks:
        position = re.search(r"position:\s+x: " + number + "y: " + number + "z: " + number, block).groups()
        q = re.search(r"orientation:\s+x: " + number + "y: " + number + "z: " + number + "w: " + number, block).groups()
        out.append(to_matrix([float(v) for v in position], [float(v) for v in q]))
    return out


def register_pair(target, source, seconds):
    odometry = voxnav.LidarOdometry()
    odometry.add_cloud(100.0, target)
    return odometry.add_cloud(100.0 + seconds, source)


def test_kitti_drive_drifts_less_than_one_percent():
    stamps = np.loadtxt(data_path("kitti_0001", "times.txt"))
    rows = np.loadtxt(data_path("kitti_0001", "poses_gt.txt"))
    truth = [to_matrix(row[1:4], row[4:8]) for row in rows]
    odometry = voxnav.LidarOdometry()
    results = [odometry.add_cloud(t, load_scan("kitti_0001", i)) for i, t in enumerate(stamps)]
    assert [r.quality.state for r in results[1:]] == ["tracking"] * (len(results) - 1)
    ratios = []
    for i in range(len(results) - 10):
        moved = np.linalg.inv(truth[i]) @ truth[i + 10]
        estimated = np.linalg.inv(results[i].pose) @ results[i + 10].pose
        ratios.append(pose_error(estimated, moved)[0] / np.linalg.norm(moved[:3, 3]))
    length = np.linalg.norm(np.diff(rows[:, 1:4], axis=0), axis=1).sum()
    print("relative error over 10 scans: mean %.2f %%, max %.2f %%; end %.2f m of %.1f m" % (
        100 * np.mean(ratios), 100 * np.max(ratios), pose_error(results[-1].pose, truth[-1])[0], length))
    # The RTK poses of the recording jitter by some centimetres from scan to scan.
    assert np.mean(ratios) < 0.01
    assert pose_error(results[-1].pose, truth[-1])[0] < 0.01 * length
    assert odometry.memory_bytes < 100e6


def test_street_pair_matches_its_reference():
    truth = np.loadtxt(data_path("small_gicp_pair", "T_target_source.txt"))
    result = register_pair(load_scan("small_gicp_pair", 0), load_scan("small_gicp_pair", 1), 0.1)
    metres, degrees = pose_error(result.pose, truth)
    assert result.quality.state == "tracking" and metres < 0.05 and degrees < 0.3


def test_forest_pairs_match_their_references():
    still = register_pair(load_scan("sloam_forest_uav", 0), load_scan("sloam_forest_uav", 1), 0.1)
    metres, degrees = pose_error(still.pose, np.eye(4))
    assert still.quality.state == "tracking" and metres < 0.05 and degrees < 0.5
    start, end = sloam_poses()
    moving = register_pair(load_scan("sloam_forest_uav", 2), load_scan("sloam_forest_uav", 3), 0.53)
    metres, degrees = pose_error(moving.pose, np.linalg.inv(start) @ end)
    # The reference is the odometry of that flight, whose standard deviation is 8 cm.
    assert moving.quality.state == "tracking" and metres < 0.12 and degrees < 1.0


def room_points(seed, count=8000):
    """Returns random points on the walls of a room of 16 x 12 x 5 m, seen from inside."""
    rng = np.random.RandomState(seed)
    points = rng.uniform(-1, 1, (count, 3)) * [8, 6, 2.5]
    axis = rng.randint(0, 3, count)
    rows = np.arange(count)
    points[rows, axis] = np.sign(points[rows, axis]) * np.array([8, 6, 2.5])[axis]
    return points.astype(np.float32)


def test_imu_makes_the_first_pose_upright():
    odometry = voxnav.LidarOdometry()
    stamps = np.arange(0.0, 0.2, 0.005)
    force = np.tile(9.81 * np.array([np.sin(0.2), 0.0, np.cos(0.2)]), (len(stamps), 1))
    odometry.add_imu(stamps, np.zeros((len(stamps), 3)), force)
    up_B = odometry.add_cloud(0.1, room_points(1)).pose[:3, :3].T @ [0, 0, 1]
    assert np.allclose(up_B, force[0] / 9.81, atol=1e-6)


def test_odometry_coasts_with_a_reason_where_scans_do_not_match():
    odometry = voxnav.LidarOdometry()
    for i in range(5):
        result = odometry.add_cloud(0.1 * i, room_points(i))
    assert result.quality.state == "tracking"
    before = result.pose
    result = odometry.add_cloud(0.5, np.random.RandomState(9).uniform(-50, 50, (8000, 3)).astype(np.float32))
    assert result.quality.state == "coasting" and result.quality.reason
    assert np.linalg.norm(result.pose[:3, 3] - before[:3, 3]) < 0.05
    assert np.all(np.linalg.eigvalsh(result.covariance) > 0)
    assert odometry.counters["coasted"] == 1


def test_bad_arguments_raise():
    odometry = voxnav.LidarOdometry()
    with pytest.raises(ValueError):
        odometry.add_cloud(0.0, np.zeros((5, 3)))
    with pytest.raises(ValueError):
        odometry.add_cloud(float("nan"), np.zeros((5, 3), np.float32))
    with pytest.raises(ValueError):
        odometry.add_cloud(0.0, np.zeros((5, 3), np.float32), np.zeros(4))
    with pytest.raises(ValueError):
        odometry.add_imu(np.zeros(3), np.zeros((2, 3)), np.zeros((3, 3)))
    with pytest.raises(ValueError):
        voxnav.LidarOdometry(T_B_L=2 * np.eye(4))
    with pytest.raises(voxnav.ConfigError, match="voxel_size_m"):
        voxnav.LidarOdometryConfig(voxel_size_m=0.0)


def test_empty_and_all_nan_clouds_are_survived():
    odometry = voxnav.LidarOdometry()
    assert odometry.add_cloud(0.0, np.zeros((0, 3), np.float32)).quality.state == "initializing"
    result = odometry.add_cloud(0.1, np.full((100, 4), np.nan, np.float32))
    assert result.quality.state == "initializing" and np.array_equal(result.pose, np.eye(4))
    assert odometry.counters["points_refused"] == 100
