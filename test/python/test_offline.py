# SPDX-License-Identifier: BSD-3-Clause
"""scripts/map_bag on small recordings of a simulated flight: a bag, a folder, and damaged ones."""

import json
import os

import numpy as np
import pytest

import voxnav
from voxnav import files
from voxnav.offline.cli import main
from voxnav.offline.datasets import interpolate_pose

simulation = pytest.importorskip("voxnav.simulation")
rosbag = pytest.importorskip("rosbag")

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SPEED_MPS, YAW_RATE_RADPS, SWEEP_S = 2.0, 0.3, 0.1
MOUNT = simulation.pose(0.1, 0.0, 0.15)
NUM_SCANS = 16


def body_pose(t):
    return simulation.pose(SPEED_MPS * t, 0.0, 2.0, YAW_RATE_RADPS * t)


@pytest.fixture(scope="module")
def scans():
    """Organised scans (h, w, 4) with column times (w,), of a sensor that moves while it turns."""
    world = simulation.World(os.path.join(ROOT, "worlds", "grove.yaml"), seed=2)
    lidar = simulation.Lidar(model="os0-32", columns=256, dropout_ratio=0.0)
    return world, [lidar.scan(world, body_pose(t) @ MOUNT, body_pose(t + SWEEP_S) @ MOUNT, scan_index=i)
                   for i, t in enumerate(1.0 + SWEEP_S * np.arange(NUM_SCANS))]


def cloud_message(scan, stamp):
    import rospy
    from sensor_msgs.msg import PointCloud2, PointField

    height, width = scan.ranges_m.shape
    rows = np.zeros((height, width), dtype=[("xyzi", "<f4", 4), ("t", "<u4")])
    rows["xyzi"] = scan.organised
    rows["t"] = np.round(scan.column_times_s * 1e9).astype(np.uint32)[None, :]
    msg = PointCloud2(height=height, width=width, point_step=20, row_step=20 * width, data=rows.tobytes())
    msg.fields = [PointField(n, 4 * i, 7, 1) for i, n in enumerate(("x", "y", "z", "intensity"))]
    msg.fields.append(PointField("t", 16, 6, 1))
    msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(stamp), "lidar"
    return msg


def set_pose(pose, T):
    position = pose.position if hasattr(pose, "position") else pose.translation
    orientation = pose.orientation if hasattr(pose, "orientation") else pose.rotation
    position.x, position.y, position.z = T[:3, 3]
    orientation.x, orientation.y, orientation.z, orientation.w = files.quaternion_from_rotation(T[:3, :3])


@pytest.fixture(scope="module")
def bag(scans, tmp_path_factory):
    import rospy
    from geometry_msgs.msg import TransformStamped
    from nav_msgs.msg import Odometry
    from tf2_msgs.msg import TFMessage

    path = str(tmp_path_factory.mktemp("bag") / "flight.bag")
    with rosbag.Bag(path, "w", chunk_threshold=100000) as out:
        mount = TransformStamped(child_frame_id="lidar")
        mount.header.frame_id = "body"
        set_pose(mount.transform, MOUNT)
        out.write("/tf_static", TFMessage([mount]), rospy.Time.from_sec(0.9))
        for i, t in enumerate(np.arange(0.9, 1.2 + SWEEP_S * NUM_SCANS, 0.02)):
            odometry = Odometry(child_frame_id="body")
            odometry.header.stamp, odometry.header.frame_id = rospy.Time.from_sec(t), "odom"
            set_pose(odometry.pose.pose, body_pose(t))
            out.write("/odom", odometry, rospy.Time.from_sec(t))
        for i, scan in enumerate(scans[1]):
            stamp = 1.0 + SWEEP_S * i
            out.write("/points", cloud_message(scan, stamp), rospy.Time.from_sec(stamp + SWEEP_S))
    return path


@pytest.fixture(scope="module")
def config(tmp_path_factory):
    path = str(tmp_path_factory.mktemp("config") / "small.yaml")
    with open(path, "w") as out:
        out.write("schedule: {period_s: 0.7, min_period_s: 0.5}\n")
    return path


def read(directory, name):
    with open(os.path.join(str(directory), name), "rb") as source:
        return source.read()


def test_the_same_bag_gives_the_same_bytes(bag, config, tmp_path):
    for name in ("a", "b"):
        assert main([bag, "--config", config, "--out", str(tmp_path / name)]) == 0
    for name in ("trajectory.txt", "trajectory_odom.txt", "occupied.ply", "obstacles.ply", "mesh.ply", "map.ot"):
        content = read(tmp_path / "a", name)
        assert len(content) > 100
        assert content == read(tmp_path / "b", name), name
    metrics = json.loads(read(tmp_path / "a", "metrics.json"))
    assert metrics["counts"]["scans"] == NUM_SCANS and metrics["counts"]["submaps"] >= 2
    assert metrics["warnings"] == []
    assert {"mean_ms", "median_ms", "p99_ms", "max_ms"} <= set(metrics["stages"]["local map"])
    assert len(voxnav.SubmapCollection.load(str(tmp_path / "a" / "map")).occupied_points()) > 100


def test_the_map_lies_on_the_true_surface_although_the_sensor_moves(bag, scans, config, tmp_path):
    assert main([bag, "--config", config, "--out", str(tmp_path)]) == 0
    points = voxnav.SubmapCollection.load(str(tmp_path / "map")).occupied_points()
    distances = scans[0].surface_distance(points.astype(np.float64))
    assert np.mean(distances < 0.2) > 0.95  # half a voxel
    stamps, poses = files.read_tum(str(tmp_path / "trajectory_odom.txt"))
    errors = [np.linalg.norm(T[:3, 3] - body_pose(t)[:3, 3]) for t, T in zip(stamps, poses)]
    assert max(errors) < 0.15  # a pose stands for the middle of its sweep


def test_a_truncated_bag_is_mapped_as_far_as_it_is_intact(bag, config, tmp_path, capsys):
    cut = str(tmp_path / "cut.bag")
    content = read(os.path.dirname(bag), os.path.basename(bag))
    with open(cut, "wb") as out:
        out.write(content[:int(0.6 * len(content))])
    assert main([cut, "--config", config, "--out", str(tmp_path / "out")]) == 0
    assert "not closed properly" in capsys.readouterr().out
    metrics = json.loads(read(tmp_path / "out", "metrics.json"))
    assert 3 < metrics["counts"]["scans"] < NUM_SCANS
    assert read(os.path.dirname(cut), "cut.bag") == content[:int(0.6 * len(content))]  # the original is left alone


@pytest.mark.parametrize("content, words", [(None, "no such file"), (b"", "not a readable bag"),
                                            (b"#ROSBAG V2.0\nrubbish" * 50, "recovered")])
def test_unusable_bags_are_refused_with_a_reason(content, words, tmp_path, capsys):
    path = str(tmp_path / "bad.bag")
    if content is not None:
        with open(path, "wb") as out:
            out.write(content)
    assert main([path, "--out", str(tmp_path / "out")]) == 1
    assert words in capsys.readouterr().err
    assert not os.path.exists(str(tmp_path / "out"))


def test_a_folder_of_scans_with_poses_is_mapped(scans, config, tmp_path, capsys):
    folder = tmp_path / "recording"
    (folder / "scans").mkdir(parents=True)
    stamps = SWEEP_S * np.arange(6)
    for i in range(6):
        scans[1][i].points.tofile(str(folder / "scans" / ("%06d.bin" % i)))
    np.savetxt(str(folder / "times.txt"), stamps)
    poses = np.array([body_pose(1.0 + t) @ MOUNT for t in stamps])
    files.write_tum(str(folder / "poses.txt"), stamps, poses)
    arguments = ["--scans", str(folder), "--poses", str(folder / "poses.txt"), "--config", config]
    assert main(arguments + ["--out", str(tmp_path / "out"), "--reference", str(folder / "poses.txt")]) == 0
    metrics = json.loads(read(tmp_path / "out", "metrics.json"))
    assert metrics["counts"]["scans"] == 6 and metrics["errors"]["ate_odometry_m"] < 1e-3
    assert os.path.exists(str(tmp_path / "out" / "report.html"))
    with open(str(folder / "scans" / "000003.bin"), "ab") as out:
        out.write(b"123")
    assert main(arguments + ["--out", str(tmp_path / "cut")]) == 0
    assert "truncated" in capsys.readouterr().out
    os.remove(str(folder / "times.txt"))
    np.savetxt(str(folder / "times.txt"), stamps[:3])
    assert main(arguments + ["--out", str(tmp_path / "short")]) == 1
    assert "3 times for 6 scans" in capsys.readouterr().err


def test_a_misspelt_parameter_is_named(bag, tmp_path, capsys):
    path = str(tmp_path / "bad.yaml")
    with open(path, "w") as out:
        out.write("map: {resolutoin_m: 0.2}\nfilters: {}\n")
    assert main([bag, "--config", path, "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert "resolutoin_m" in error and "filters" in error


def test_poses_are_interpolated_and_never_extrapolated():
    stamps, poses = [1.0, 2.0], [simulation.pose(0, 0, 0, 3.0), simulation.pose(2, 0, 0, -3.0)]
    middle = interpolate_pose(stamps, poses, 1.5)
    assert np.allclose(middle[:3, 3], (1, 0, 0))
    assert np.arctan2(middle[1, 0], middle[0, 0]) == pytest.approx(np.pi)  # the short way around
    assert interpolate_pose(stamps, poses, 0.99) is None and interpolate_pose(stamps, poses, 2.01) is None
