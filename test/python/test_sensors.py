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


def run(tmp_path, messages, *options, name="flight", config=""):
    pytest.importorskip("rosbag")
    bag, out = str(tmp_path / (name + ".bag")), str(tmp_path / name)
    write_messages(bag, messages)
    path = tmp_path / "config.yaml"
    path.write_text("run: {write_mesh: false}\n" + config)
    status = map_bag([bag, "--config", str(path), "--out", out] + list(options))
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


def camera_messages(world, camera, encoding="32FC1", rate_hz=10.0):
    """The images of a depth camera that flies along, with their camera_info, and where it sits."""
    import rospy
    from sensor_msgs.msg import CameraInfo, Image

    out = [[99.9, "/tf_static", link("body", "front_optical", camera.T_B_C)]]
    for i in range(int(round(rate_hz * SWEEP_S * NUM_SCANS))):
        t = 1.0 + i / rate_hz
        metres = camera.image(world, body_pose(t) @ camera.T_B_C, i)
        pixels = metres if encoding == "32FC1" else np.round(1000.0 * metres).astype(np.uint16)
        image = Image(height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, data=pixels.tobytes(),
                      step=pixels.nbytes // pixels.shape[0])
        info = CameraInfo(height=image.height, width=image.width, K=camera.K.ravel().tolist())
        for topic, msg in (("/front/depth/image_rect_raw", image), ("/front/depth/camera_info", info)):
            msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(99.0 + t), "front_optical"
            # The first camera_info comes after the first image, as that of a slow driver.
            out.append([99.0 + t + (0.03 if topic.endswith("info") else 0.01), topic, msg])
    return out


@pytest.fixture(scope="module")
def lidar_messages():
    return flight(sweeps(num_scans=NUM_SCANS)[1], first_stamp_s=100.0)


CAMERA = ["--depth-camera", "front=/front/depth/image_rect_raw"]


@pytest.mark.parametrize("encoding", ["32FC1", "16UC1"])
def test_map_bag_maps_depth_images_as_the_nodelets_do(encoding, lidar_messages, world, tmp_path, capsys):
    pytest.importorskip("rosbag")
    camera = simulation.DepthCamera(seed=3)
    messages = lidar_messages + camera_messages(world, camera, encoding)
    status, metrics, points = run(tmp_path, messages, *CAMERA)
    said = capsys.readouterr().out
    assert status == 0 and metrics["counts"]["scans"] == 2 * NUM_SCANS and metrics["left_out"] == []
    assert "/front/depth/image_rect_raw; %d messages, 'front_optical'" % NUM_SCANS in said
    single = run(tmp_path, lidar_messages, name="single")[2]
    assert np.mean(world.surface_distance(points) < 0.2) > 0.95 and len(points) > 1.005 * len(single)
    # The converter of the nodelets is asked beside, with the defaults of config/depth_cloud.yaml.
    depth, msg = voxnav.DepthCloud(), next(m[2] for m in messages if m[1] == "/front/depth/image_rect_raw")
    pixels = np.frombuffer(msg.data, np.float32 if encoding == "32FC1" else np.uint16).reshape(msg.height, msg.width)
    assert depth.convert(pixels, camera.K)[0] == depth.convert_message(msg, voxnav.camera_of(messages[-1][2]))[0]


def test_a_recording_of_a_depth_camera_alone_is_mapped_and_hinted_at(lidar_messages, world, tmp_path, capsys):
    messages = [m for m in lidar_messages if m[1] != "/points"] + camera_messages(world, simulation.DepthCamera(seed=3))
    assert run(tmp_path, messages)[0] == 1
    assert "--depth-camera /front/depth/image_rect_raw" in capsys.readouterr().err
    status, metrics, points = run(tmp_path, messages, *CAMERA)
    assert status == 0 and metrics["counts"]["scans"] == NUM_SCANS
    assert np.mean(world.surface_distance(points) < 0.4) > 0.95


def test_images_that_come_faster_than_wanted_are_left_out_and_cover_the_recording(lidar_messages, world, tmp_path):
    messages = lidar_messages + camera_messages(world, simulation.DepthCamera(seed=3), rate_hz=30.0)
    status, metrics, _ = run(tmp_path, messages, *CAMERA)
    assert status == 0 and NUM_SCANS + 11 <= metrics["counts"]["scans"] <= 2 * NUM_SCANS + 1
    assert [row["reason"] for row in metrics["left_out"]] == ["it comes sooner than max_rate_hz allows"]


@pytest.mark.parametrize("spoil, word", [
    (lambda messages: [setattr(m[2], "encoding", "rgb8") for m in messages if m[1].endswith("image_rect_raw")], "rgb8"),
    (lambda messages: [m[2].K.__setitem__(0, 0.0) for m in messages if m[1].endswith("info")], "intrinsics"),
    (lambda messages: messages.__setitem__(slice(None), [m for m in messages if not m[1].endswith("info")]),
     "nothing came on /front/depth/camera_info")])
def test_images_that_cannot_be_used_are_counted_with_the_reason(spoil, word, lidar_messages, world, tmp_path, capsys):
    images = camera_messages(world, simulation.DepthCamera(seed=3))
    spoil(images)
    status, metrics, _ = run(tmp_path, lidar_messages + images, *CAMERA)
    assert status == NOT_COVERED and metrics["counts"]["scans"] == NUM_SCANS
    assert any(row["count"] == NUM_SCANS and word in row["reason"] for row in metrics["left_out"])
    assert check_recording([str(tmp_path / "flight.bag")] + CAMERA) == 3
    assert word in capsys.readouterr().out


NAMED = ["--cloud", "/points", "--cloud", "rear=/rear/points"]


def test_each_sensor_has_its_own_sections(two_lidars, tmp_path):
    def sizes(config, name):
        status, metrics, points = run(tmp_path, two_lidars, *NAMED, name=name, config=config)
        assert status == 0
        return metrics["counts"]["points_kept"], len(points)
    kept, size = sizes("", "all")
    assert sizes("cloud_filter_rear: {filter: {column_decimation: 4}}\n", "filter")[0] < 0.8 * kept
    assert sizes("filter: {column_decimation: 4}\ncloud_filter_rear: {filter: {column_decimation: 1}}\n",
                 "over")[0] < 0.8 * kept
    near = sizes("local_mapper: {rear: {max_range_m: 1.0}}\n", "near")
    assert near[0] == kept and near[1] < size


@pytest.mark.parametrize("config, words", [
    ("cloud_filter_rear: {filter: {min_range: 1.0}}\n", "cloud_filter_rear/filter/min_range"),
    ("cloud_filter_rear: {depth: {}}\n", "cloud_filter_rear/depth: unknown section"),
    ("cloud_filter_front: {filter: {}}\n", "cloud_filter_front: unknown section"),
    ("local_mapper: {map: {resolution_m: 0.2}}\n", "local_mapper/map: no sensor of that name"),
    ("local_mapper: {rear: {max_range_m: -1.0}}\n", "local_mapper/rear/max_range_m"),
    ("cloud_filter_rear: 3\n", "cloud_filter_rear: is a section")])
def test_wrong_sections_of_sensors_are_refused_by_name(config, words, two_lidars, tmp_path, capsys):
    assert run(tmp_path, two_lidars, *NAMED, config=config)[0] == 1
    assert words in capsys.readouterr().err
    if "min_range" in words:
        assert run(tmp_path, two_lidars, "--cloud", "a=/points", "--cloud", "a=/rear/points", name="twice")[0] == 1
        assert "two sensors are called a" in capsys.readouterr().err
