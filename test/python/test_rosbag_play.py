# SPDX-License-Identifier: BSD-3-Clause
"""A recording that ``rosbag play --clock`` replays beside launch/bag.launch is mapped, with the right mount."""

import os
import subprocess
import time
import xmlrpc.client

import numpy as np
import pytest

pytest.importorskip("voxnav.simulation")
pytest.importorskip("rosbag")
roslaunch = pytest.importorskip("roslaunch")

import voxnav  # noqa: E402
from recordings import ABSOLUTE_TIMES, ROOT, body_pose, flight, link, sweeps, write_messages  # noqa: E402
from voxnav.demo import processes  # noqa: E402
from voxnav.offline.configs import mount_of  # noqa: E402
from voxnav.recordings.bag_files import BagFiles  # noqa: E402
from voxnav.recordings.errors import DatasetError  # noqa: E402
from voxnav.recordings.plan import BagOptions, RecordingPlan  # noqa: E402

NUM_SCANS, FIRST_S, LIMIT_S = 20, 500.0, 120.0
MOUNT = mount_of((0.3, -0.2, 0.4), (0.1, 0.3, 1.2))
# On a busy machine scans and poses come late in real time, so the limits for them are wide.
CONFIG = "local_mapper: {node: {tf_timeout_s: 5.0}, mapper: {max_pending_scans: 50}}\n"


def recording():
    """Returns (world, messages), with the poses on /tf and absolute point times in seconds."""
    world, scans = sweeps(MOUNT, NUM_SCANS)
    messages = flight(scans, MOUNT, first_stamp_s=FIRST_S, times=ABSOLUTE_TIMES)
    for t in np.arange(0.9, 1.3 + 0.1 * NUM_SCANS, 0.02):
        stamp = t + FIRST_S - 1.0
        messages.append([stamp, "/tf", link("odom", "body", body_pose(t), stamp)])
    return world, messages


def wait_for_service(master, name):
    deadline = time.monotonic() + LIMIT_S
    while time.monotonic() < deadline:
        try:
            if master.lookupService("/test", name)[0] == 1:
                return
        except (OSError, xmlrpc.client.Error):
            pass
        time.sleep(0.1)
    raise AssertionError("no service %s" % name)


def call(env, *words):
    done = subprocess.run(["rosservice", "call"] + list(words), env=env, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, universal_newlines=True, timeout=LIMIT_S)
    assert done.returncode == 0 and "success: True" in done.stdout, done.stdout


def is_heard(master, topic):
    return bool(dict(master.getSystemState("/test")[2][1]).get(topic))


def wait_until(condition):
    deadline = time.monotonic() + LIMIT_S
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.1)
    return condition()


def map_of(env, folder):
    """Returns the points of the global map as soon as it has any."""
    deadline = time.monotonic() + LIMIT_S
    while time.monotonic() < deadline:
        call(env, "/uav1/local_mapper/close_submap")
        call(env, "/uav1/submap_optimizer/optimize")
        call(env, "/uav1/submap_integrator/save", "value: '%s'" % folder)
        points = voxnav.SubmapCollection.load(folder).occupied_points().astype(np.float64)
        if len(points) > 100:
            return points
    raise AssertionError("the map stayed empty")


def test_a_played_recording_is_mapped_where_the_world_is(tmp_path):
    world, messages = recording()
    bag = write_messages(str(tmp_path / "flight.bag"), messages)
    config, log = tmp_path / "own.yaml", str(tmp_path / "roslaunch.log")
    config.write_text(CONFIG)
    arguments = {"cloud_topic": "/points", "imu_topic": "/imu", "odometry": "external", "odometry_frame": "odom",
                 "body_frame": "body", "custom_config": str(config)}
    launched, env = processes.launch("bag.launch", arguments, log)
    try:
        master = xmlrpc.client.ServerProxy(env["ROS_MASTER_URI"])
        for name in ("local_mapper/close_submap", "submap_integrator/save", "submap_optimizer/optimize"):
            wait_for_service(master, "/uav1/" + name)
        assert wait_until(lambda: is_heard(master, "/points") and is_heard(master, "/uav1/cloud_filter/points"))
        # The player waits until connections are established, and plays slowly because the machine may be busy.
        with processes.Process(["rosbag", "play", "--clock", "--delay", "3", "-r", "0.5", bag],
                               str(tmp_path / "player.log"), env) as player:
            assert wait_until(lambda: not player.is_running())
        points = map_of(env, str(tmp_path / "map"))
    finally:
        launched.stop()
    assert np.mean(world.surface_distance(points) < 0.2) > 0.95  # 0.2 m is half a voxel


def plan_of(tmp_path, messages, **options):
    files = BagFiles([write_messages(str(tmp_path / "flight.bag"), messages)])
    plan = RecordingPlan(files, BagOptions(**options))
    files.close()
    return plan


def test_the_player_takes_the_mount_from_the_recording_and_never_the_identity(tmp_path):
    from voxnav.nodes.recording_mount import missing_link

    scans = sweeps(MOUNT, 4)[1]
    messages = flight(scans, MOUNT, first_stamp_s=FIRST_S)
    plan = plan_of(tmp_path, messages)
    assert missing_link(plan, "body") is None  # the recording holds this transform
    parent, child, T = missing_link(plan, "uav1/fcu")
    assert (parent, child) == ("uav1/fcu", "body") and np.allclose(T, np.eye(4))
    lidar_only = flight(scans, MOUNT, first_stamp_s=FIRST_S, with_odometry=False)
    parent, child, T = missing_link(plan_of(tmp_path, lidar_only), "uav1/fcu")
    assert child == "body" and np.allclose(T @ MOUNT, np.eye(4))  # without odometry, poses are those of the LiDAR
    moving = messages + [[FIRST_S + i, "/tf", link("odom", "body", body_pose(float(i)))] for i in range(3)]
    with pytest.raises(DatasetError, match="body_frame:=body"):
        missing_link(plan_of(tmp_path, moving), "uav1/fcu")
    with pytest.raises(DatasetError, match="--mount"):
        missing_link(plan_of(tmp_path, [m for m in messages if m[1] != "/tf_static"]), "uav1/fcu")


def test_the_launch_file_publishes_a_mount_only_where_one_is_given():
    path = os.path.join(ROOT, "launch", "bag.launch")
    os.environ.setdefault("BOND", "")
    names = []
    for arguments in ([], ["bag:=x.bag"], ["sensor_mount:=0 0 1 0 0 0"]):
        config = roslaunch.config.load_config_default([(path, arguments)], None, verbose=False,
                                                      assign_machines=False)
        names.append({node.name for node in config.nodes} & {"sensor_mount", "recording_mount"})
    assert names == [set(), {"recording_mount"}, {"sensor_mount"}]
