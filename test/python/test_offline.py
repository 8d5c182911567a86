# SPDX-License-Identifier: BSD-3-Clause
"""scripts/map_bag maps small recordings of a simulated flight from a bag, a folder, and damaged bags."""

import gc
import json
import os
import tempfile

import numpy as np
import pytest

import voxnav
from voxnav import files
from voxnav.offline.cli import main

simulation = pytest.importorskip("voxnav.simulation")
pytest.importorskip("rosbag")

from recordings import MOUNT, NUM_SCANS, SWEEP_S, body_pose, sweeps, write_bag  # noqa: E402


@pytest.fixture(scope="module")
def scans():
    return sweeps()


@pytest.fixture(scope="module")
def bag(scans, tmp_path_factory):
    path = str(tmp_path_factory.mktemp("bag") / "flight.bag")
    write_bag(path, scans[1])
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
    assert np.mean(distances < 0.2) > 0.95  # 0.2 m is half a voxel
    stamps, poses = files.read_tum(str(tmp_path / "trajectory_odom.txt"))
    errors = [np.linalg.norm(T[:3, 3] - body_pose(t)[:3, 3]) for t, T in zip(stamps, poses)]
    assert max(errors) < 0.15  # the body moves 0.1 m in half a sweep, for whose middle a pose holds


def test_a_truncated_bag_is_mapped_as_far_as_it_is_intact(bag, config, tmp_path, capsys, monkeypatch):
    copies = tmp_path / "copies"
    copies.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(copies))
    cut = str(tmp_path / "cut.bag")
    content = read(os.path.dirname(bag), os.path.basename(bag))
    with open(cut, "wb") as out:
        out.write(content[:int(0.6 * len(content))])
    assert main([cut, "--config", config, "--out", str(tmp_path / "out")]) == 0
    assert "not closed properly" in capsys.readouterr().out
    metrics = json.loads(read(tmp_path / "out", "metrics.json"))
    assert 3 < metrics["counts"]["scans"] < NUM_SCANS
    assert read(os.path.dirname(cut), "cut.bag") == content[:int(0.6 * len(content))]  # the original is not changed
    gc.collect()
    assert [name for name in os.listdir(str(copies)) if name.endswith(".bag")] == []


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


def test_poses_are_interpolated_and_never_extrapolated(tmp_path):
    turned = voxnav.interpolate_pose(simulation.pose(0, 0, 0, 3.0), simulation.pose(2, 0, 0, -3.0), 0.5)
    assert np.allclose(turned[:3, 3], (1, 0, 0))
    assert abs(voxnav.yaw_of(turned)) == pytest.approx(np.pi)  # the shorter of the two rotations is interpolated
    mapper = voxnav.Mapper(voxnav.MapperConfig(max_pose_gap_s=1.0))
    result = voxnav.CloudFilter(voxnav.CloudFilterConfig()).apply(np.full((20, 4), 5.0, np.float32))
    for stamp_s in (0.99, 1.5, 2.01):
        mapper.queue_sweep(result.sweep(int(1e9 * stamp_s)))
    for stamp_s, x in ((1.0, 0.0), (2.0, 2.0)):
        mapper.add_pose(int(1e9 * stamp_s), simulation.pose(x, 0, 0))
    mapper.end_input()
    steps = []
    while mapper.has_next():
        steps.append(mapper.next())
    assert [s.fate for s in steps] == [voxnav.SweepFate.NO_POSE, voxnav.SweepFate.MAPPED, voxnav.SweepFate.NO_POSE]
    assert np.allclose(steps[1].T_O_B[:3, 3], (1, 0, 0))


def test_poses_are_not_interpolated_over_a_gap():
    mapper = voxnav.Mapper(voxnav.MapperConfig(max_pose_gap_s=0.9))
    result = voxnav.CloudFilter(voxnav.CloudFilterConfig()).apply(np.full((20, 4), 5.0, np.float32))
    for stamp_s in (1.0, 1.5, 2.0):
        mapper.queue_sweep(result.sweep(int(1e9 * stamp_s)))
    for stamp_s in (1.0, 2.0):
        mapper.add_pose(int(1e9 * stamp_s), np.eye(4))
    steps = []
    while mapper.has_next():
        steps.append(mapper.next())
    assert [s.fate for s in steps] == [voxnav.SweepFate.MAPPED, voxnav.SweepFate.NO_POSE, voxnav.SweepFate.MAPPED]
    assert "1.0" in steps[1].reason and "apart" in steps[1].reason
