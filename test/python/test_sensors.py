# SPDX-License-Identifier: BSD-3-Clause
"""Several sensors in one map against the true surface: a second LiDAR, a depth camera, a recording of two LiDARs."""

import json

import numpy as np
import pytest

pytest.importorskip("voxnav.simulation")

import voxnav  # noqa: E402
from recordings import (MOUNT, ROOT, SWEEP_S, body_pose, cloud_message, flight, link, sweeps,  # noqa: E402
                        write_messages)
from voxnav import simulation  # noqa: E402
from voxnav.offline.check import main as check_recording  # noqa: E402
from voxnav.offline.cli import NOT_COVERED, main as map_bag  # noqa: E402
from voxnav.offline.configs import mount_of  # noqa: E402

NUM_SCANS = 12
TILTED = mount_of((-0.15, 0.0, -0.05), (0.0, 0.6, np.pi))  # looks down at the back
RESOLUTION_M = 0.4


@pytest.fixture(scope="module")
def world():
    return simulation.World(ROOT + "/worlds/grove.yaml", seed=2)


def filtered(cloud, number, stamp_s, layout=None):
    sensor_filter = voxnav.CloudFilter(voxnav.CloudFilterConfig(body_radius_m=0.4))
    result = sensor_filter.apply(cloud) if layout is None else sensor_filter.apply_raw(cloud, layout)
    return result.sweep(int(round(1e9 * stamp_s)), sensor=number)


def lidar_sweep(world, T_B_L, number, index):
    lidar = simulation.Lidar(model="os0-32", columns=256, dropout_ratio=0.0, seed=7 + number)
    t = 1.0 + SWEEP_S * index
    return filtered(lidar.scan(world, body_pose(t) @ T_B_L, scan_index=index).organised, number, t)


def camera_sweep(world, camera, number, index):
    t = 1.0 + SWEEP_S * index
    image = camera.image(world, body_pose(t) @ camera.T_B_C, index)
    depth = voxnav.DepthCloud(voxnav.DepthCloudConfig(row_step=1, column_step=1))
    millimetres = np.round(1000.0 * image).astype(np.uint16)
    cloud, layout = depth.convert(millimetres, camera.K)
    return filtered(cloud, number, t, layout)


def mapped(sensors, configs):
    """The map of some sensors. sensors: (T_B_L, sweep of a number and index) of each."""
    config = voxnav.MapperConfig(use_deskew=False)
    config.sensors = configs
    mapper = voxnav.Mapper(config, sensors[0][0])
    for number, (T_B_L, _) in enumerate(sensors):
        mapper.set_mount(number, T_B_L)
    for index in range(NUM_SCANS):
        t = 1.0 + SWEEP_S * index
        mapper.add_pose(int(round(1e9 * t)), body_pose(t))
        for number, (_, sweep) in enumerate(sensors):
            mapper.queue_sweep(sweep(number, index))
            while mapper.has_next():
                step = mapper.next()
                assert step.fate == voxnav.SweepFate.MAPPED, step.reason
    return mapper.map


def surface_near_the_path(world):
    """Middles of the triangles of the true surface, (n, 3), within 8 m of the flight."""
    vertices, triangles, _ = world.mesh()
    middles = vertices[triangles].mean(axis=1).astype(np.float64)
    path = np.array([body_pose(1.0 + SWEEP_S * i)[:3, 3] for i in range(NUM_SCANS)])
    distance = np.min(np.linalg.norm(middles[:, None, :] - path[None], axis=2), axis=1)
    return middles[distance < 8.0].astype(np.float32)


def share_right(world, local_map, within_m):
    points = local_map.occupied_points().astype(np.float64)
    assert len(points) > 100
    return np.mean(world.surface_distance(points) < within_m)


def test_a_second_lidar_shows_what_the_first_does_not_see(world):
    first = (MOUNT, lambda number, index: lidar_sweep(world, MOUNT, number, index))
    second = (TILTED, lambda number, index: lidar_sweep(world, TILTED, number, index))
    alone = mapped([first], [voxnav.SensorConfig()])
    both = mapped([first, second], [voxnav.SensorConfig()] * 2)
    surface = surface_near_the_path(world)
    assert len(surface) > 500
    states = [m.states(surface) for m in (alone, both)]
    occupied, free = [np.mean(s == 2) for s in states], [np.mean(s == 1) for s in states]
    assert share_right(world, both, 0.5 * RESOLUTION_M) > 0.97
    assert occupied[1] > occupied[0] + 0.02
    assert free[1] <= free[0] + 0.002


def test_a_depth_camera_adds_its_surfaces_and_takes_none_away(world):
    camera = simulation.DepthCamera(seed=3)
    first = (MOUNT, lambda number, index: lidar_sweep(world, MOUNT, number, index))
    second = (camera.T_B_C, lambda number, index: camera_sweep(world, camera, number, index))
    limits = voxnav.SensorConfig(max_range_m=6.0, no_return_range_m=0.0, range_noise_m=0.17)
    alone, both = mapped([first], [voxnav.SensorConfig()]), mapped([first, second], [voxnav.SensorConfig(), limits])
    camera_alone = mapped([second], [limits])
    surface = surface_near_the_path(world)
    states = [m.states(surface) for m in (alone, both, camera_alone)]
    occupied, free = [np.mean(s == 2) for s in states], [np.mean(s == 1) for s in states]
    assert share_right(world, camera_alone, RESOLUTION_M) > 0.95  # its ranges are off by half a voxel
    assert share_right(world, both, 0.5 * RESOLUTION_M) > 0.97
    assert occupied[2] > 0.05 and occupied[1] > occupied[0]
    assert free[1] <= free[0] + 0.005


@pytest.fixture(scope="module")
def two_lidars():
    """The messages of a flight with two LiDARs: on /points and /rear/points."""
    scans = sweeps(num_scans=NUM_SCANS)[1]
    messages = flight(scans, first_stamp_s=100.0)
    messages.append([99.9, "/tf_static", link("lidar", "rear", np.linalg.inv(MOUNT) @ TILTED)])
    for i, scan in enumerate(sweeps(TILTED, num_scans=NUM_SCANS)[1]):
        msg = cloud_message(scan, 100.0 + SWEEP_S * i)
        msg.header.frame_id = "rear"
        messages.append([100.0 + SWEEP_S * (i + 1), "/rear/points", msg])
    return messages


def run(tmp_path, messages, *options, name="flight"):
    pytest.importorskip("rosbag")
    bag, out = str(tmp_path / (name + ".bag")), str(tmp_path / name)
    write_messages(bag, messages)
    config = tmp_path / "config.yaml"
    config.write_text("run: {write_mesh: false}\n")
    status = map_bag([bag, "--config", str(config), "--out", out] + list(options))
    if status not in (0, NOT_COVERED):
        return status, {}, None
    with open(out + "/metrics.json") as source:
        metrics = json.load(source)
    return status, metrics, voxnav.SubmapCollection.load(out + "/map").occupied_points().astype(np.float64)


def test_map_bag_maps_several_clouds_each_with_its_own_mount(two_lidars, world, tmp_path, capsys):
    options = ["--cloud", "/points", "--cloud", "/rear/points"]
    status, metrics, points = run(tmp_path, two_lidars, *options)
    assert status == 0 and metrics["counts"]["scans"] == 2 * NUM_SCANS
    assert "/rear/points" in capsys.readouterr().out
    _, single, points_of_one = run(tmp_path, two_lidars, *options[:2], name="single")
    assert single["counts"]["scans"] == NUM_SCANS
    assert np.mean(world.surface_distance(points) < 0.2) > 0.95
    assert len(points) > 1.1 * len(points_of_one)
    again = run(tmp_path, two_lidars, *options, name="again")[2]
    assert np.array_equal(points, again)


def test_a_cloud_whose_mount_nothing_tells_is_refused_by_name(two_lidars, tmp_path, capsys):
    messages = [m for m in two_lidars if m[1] != "/tf_static" or m[2].transforms[0].child_frame_id != "rear"]
    options = ["--cloud", "/points", "--cloud", "/rear/points"]
    assert run(tmp_path, messages, *options)[0] == 1
    assert "'rear'" in capsys.readouterr().err
    assert run(tmp_path, messages, "--cloud", "/points", "--cloud", "/points")[0] == 1
    assert "twice" in capsys.readouterr().err


def test_a_second_lidar_that_fails_in_a_recording_costs_itself_and_is_said(two_lidars, tmp_path):
    messages = [m for m in two_lidars if m[1] != "/rear/points" or m[0] < 100.5]
    bad = [m for m in messages if m[1] == "/rear/points"][1]
    good_data, bad[2].data = bad[2].data, bad[2].data[:100]
    status, metrics, _ = run(tmp_path, messages, "--cloud", "/points", "--cloud", "/rear/points")
    bad[2].data = good_data
    left = metrics["left_out"]
    assert len(left) == 1 and left[0]["what"] == "cloud on /rear/points" and left[0]["count"] == 1
    assert metrics["counts"]["scans"] == NUM_SCANS + 3
    assert status in (0, NOT_COVERED)


def test_check_recording_shows_both_clouds(two_lidars, tmp_path, capsys):
    pytest.importorskip("rosbag")
    bag = write_messages(str(tmp_path / "two.bag"), two_lidars)
    assert check_recording([bag, "--cloud", "/points", "--cloud", "/rear/points"]) in (0, 3)
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("clouds")]
    assert len(lines) == 2 and "/points" in lines[0] and "lidar -> rear" in lines[1]
