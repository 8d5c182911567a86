# SPDX-License-Identifier: BSD-3-Clause
"""The mount of a sensor is found over any chain of constant transforms, and is an error if no transform gives it."""

import numpy as np
import pytest

from voxnav.offline.configs import given_mount, mount_from_words, mount_of
from voxnav.recordings.errors import DatasetError
from voxnav.recordings.frames import FrameGraph
from voxnav.recordings.mount import find_mount

import voxnav

A, B, C = (mount_of((0.1 * i, -0.2, 0.3), (0.1 * i, 0.2, -0.3 * i)) for i in (1, 2, 3))


class Topic:
    def __init__(self, name, frame, child=""):
        self.name, self.frame, self.child = name, frame, child


class Survey:
    def __init__(self, frames):
        self.frames = frames

    def see_all_frames(self):
        pass


def graph(*links):
    frames = FrameGraph()
    for parent, child, T in links:
        frames.add(parent, child, T)
    return frames


def mount(frames, cloud="lidar", body="base", imu=None, T_B_L=None):
    odometry = None if body is None else Topic("/odom", "odom", body)
    return find_mount(Survey(frames), Topic("/points", cloud), odometry, None if imu is None else Topic("/imu", imu),
                      T_B_L)


def test_chains_are_followed_in_both_directions():
    frames = graph(("base", "sensor", A), ("sensor", "lidar", B), ("sensor", "imu", C))
    assert np.allclose(frames.chain("base", "lidar").T_A_B, A @ B)
    assert np.allclose(frames.chain("imu", "lidar").T_A_B, np.linalg.inv(C) @ B)
    assert frames.chain("imu", "lidar").frames == ["imu", "sensor", "lidar"]
    assert frames.chain("base", "camera") is None
    assert frames.root("lidar") == "base" and frames.root("stranger") == "stranger"
    inverted = graph(("sensor", "base", np.linalg.inv(A)), ("lidar", "sensor", np.linalg.inv(B)))
    assert np.allclose(inverted.chain("base", "lidar").T_A_B, A @ B)


def test_a_link_that_moves_is_no_mount_and_is_named():
    frames = graph(("gimbal", "lidar", B))
    for angle in (0.0, 0.2):
        frames.add("base", "gimbal", mount_of((0, 0, 0), (0, 0, angle)), is_static=False)
    with pytest.raises(DatasetError, match="'gimbal' moves against 'base'"):
        mount(frames)


def test_a_constant_link_on_tf_counts_as_static():
    frames = FrameGraph()
    for i in range(100):
        frames.add("base", "lidar", mount_of((0.1, 0, 1e-5 * (i % 2)), (0, 0, 0.5)), is_static=False)
    assert mount(frames).T_B_L[0, 3] == 0.1


def test_of_a_static_link_that_was_sent_twice_the_last_one_counts_and_this_is_reported():
    frames = graph(("base", "lidar", A), ("base", "lidar", B))
    assert np.allclose(mount(frames).T_B_L, B)
    assert "different values" in frames.warnings[0].what


@pytest.mark.parametrize("frames", [graph(), graph(("base", "camera", A)), graph(("other", "lidar", A))])
def test_an_unknown_mount_is_an_error_that_names_frames_and_option(frames):
    with pytest.raises(DatasetError) as caught:
        mount(frames)
    for word in ("'base'", "'lidar'", "/odom", "/points", "--mount", "run/mount_position_m", "mount_source"):
        assert word in str(caught.value)
    assert np.allclose(mount(frames, T_B_L=C).T_B_L, C)


def test_the_mount_of_the_imu_may_be_known_through_the_lidar():
    frames = graph(("lidar", "imu", B))
    found = mount(frames, imu="imu", T_B_L=A)
    assert np.allclose(found.R_B_I, (A @ B)[:3, :3])
    assert mount(frames, imu="elsewhere", T_B_L=A).R_B_I is None  # with odometry the IMU's mount is not needed


def test_without_odometry_the_imu_is_the_body_and_must_be_known():
    frames = graph(("sensor", "lidar", A), ("sensor", "imu", B))
    found = mount(frames, body=None, imu="imu")
    assert np.allclose(found.T_B_L, np.linalg.inv(B) @ A) and np.array_equal(found.R_B_I, np.eye(3))
    with pytest.raises(DatasetError, match="use_imu"):
        mount(graph(), body=None, imu="imu")
    with pytest.raises(DatasetError):
        mount(graph(), cloud="", body=None, imu="")
    assert np.array_equal(mount(graph(), body=None).T_B_L, np.eye(4))
    assert np.array_equal(mount(graph(), body=None, imu="lidar").T_B_L, np.eye(4))


def test_an_unnamed_body_is_the_root_above_the_lidar_and_this_is_reported():
    found = mount(graph(("base", "lidar", A)), body="")
    assert np.allclose(found.T_B_L, A) and found.body == "base" and "child_frame_id" in found.notes[0].what
    frames = graph(("base", "lidar", A), ("above", "base", B))
    for x in (0.0, 1.0):
        frames.add("odom", "base", mount_of((x, 0, 0), (0, 0, 0)), is_static=False)
    assert "'above'" in mount(frames, body="").notes[0].what
    with pytest.raises(DatasetError):
        mount(graph(), body="")


def test_transforms_that_are_not_rigid_are_refused():
    for ends in (("", "lidar"), ("base", ""), ("base", "base")):
        with pytest.raises(ValueError):
            FrameGraph().add(ends[0], ends[1], A)


def test_a_mount_is_given_by_words_or_configuration():
    assert np.allclose(mount_from_words("1 2 3 0 0 1.5")[:3, 3], (1, 2, 3))
    for text in ("1 2 3", "1 2 3 4 5 nan", "a b c d e f"):
        with pytest.raises(ValueError, match="six numbers"):
            mount_from_words(text)
    settings = voxnav.OfflineConfig()
    assert given_mount(None, settings) is None
    assert np.array_equal(given_mount(None, voxnav.OfflineConfig(mount_source="given")), np.eye(4))
    set_one = dict(mount_position_m=[0.1, 0.0, 0.0])
    assert given_mount(None, voxnav.OfflineConfig(**set_one))[0, 3] == 0.1
    assert given_mount(None, voxnav.OfflineConfig(mount_source="recording", **set_one)) is None
    assert given_mount("0 0 1 0 0 0", voxnav.OfflineConfig(**set_one))[2, 3] == 1.0
