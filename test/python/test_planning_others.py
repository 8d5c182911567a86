# SPDX-License-Identifier: BSD-3-Clause
"""The node's part of other UAVs: those that were never heard are named, and an old transform places nobody."""

import types

import numpy as np
import pytest

import voxnav

pytest.importorskip("rospy", reason="rospy is not installed")
import rospy  # noqa: E402
from mrs_msgs.msg import FutureTrajectory  # noqa: E402

from voxnav.fences import FenceError  # noqa: E402
from voxnav.nodes.planning_others import PlanningOthers  # noqa: E402

UTM = np.array([446363.0, 5468016.5, 0.0])


class Listener:
    """A PlanningOthers of uav1, the tf that it asks, and what it passes on."""

    def __init__(self, monkeypatch, **config):
        self.said, self.passed, self.now_s = [], [], 100.0
        self.tf_stamp_s, self.tf_problem = None, ""
        for name in ("Subscriber", "get_param"):
            monkeypatch.setattr(rospy, name, lambda *_, **__: [])
        monkeypatch.setattr(rospy, "Publisher", lambda *_, **__: types.SimpleNamespace(
            publish=lambda msg: None, get_num_connections=lambda: 0))
        monkeypatch.setattr(rospy, "loginfo", lambda *_: None)
        monkeypatch.setattr(rospy, "logerr", lambda text, *values: self.said.append(text % values))
        monkeypatch.setattr(rospy, "logwarn", lambda text, *values: self.said.append(text % values))
        monkeypatch.setattr(rospy, "logwarn_throttle", lambda _, text, *values: None)
        self.inputs = types.SimpleNamespace(odometry_frame="uav1/gps_origin")
        fences = types.SimpleNamespace(timed_T_O=self.timed_T_O, world_origin=None)
        seam = types.SimpleNamespace(now=lambda: rospy.Time.from_sec(self.now_s))
        self.others = PlanningOthers(voxnav.OtherUavsConfig(robot_names=["uav1", "uav2", "uav3"], **config),
                                     self.inputs, "uav1", fences, lambda *passed: self.passed.append(passed), seam)

    def timed_T_O(self, frame):
        if self.tf_problem:
            raise FenceError(self.tf_problem)
        T_O_utm = np.eye(4)
        T_O_utm[:3, 3] = -UTM
        return T_O_utm, self.now_s if self.tf_stamp_s is None else self.tf_stamp_s

    def hear(self, *names):
        for name in names:
            msg = FutureTrajectory(stamp=rospy.Time.from_sec(self.now_s), uav_name=name, priority=int(name[-1]))
            msg.points = [types.SimpleNamespace(x=UTM[0] + 20.0, y=UTM[1], z=2.0)] * 40
            self.others._on_trajectory(name, msg)

    def update(self, seconds=0.0):
        """Returns (names that are passed on or None, the problem)."""
        self.now_s += seconds
        self.others.update()
        others, problem = self.passed[-1]
        return (None if others is None else [other.name for other in others]), problem


def test_one_that_was_never_heard_is_named_once_and_in_the_diagnostics(monkeypatch):
    listener = Listener(monkeypatch)
    for _ in range(20):
        assert listener.update(0.1) == ([], ""), "it is flown as if they were absent"
    assert listener.said == ["other UAVs: not heard yet: uav2, uav3"]
    assert listener.others.warning == "other UAVs that were never heard, and count as absent: uav2, uav3"
    listener.hear("uav2")
    assert listener.update(0.1) == (["uav2"], "")
    assert listener.others.warning.endswith("count as absent: uav3") and len(listener.said) == 1
    listener.hear("uav3")
    assert listener.update(0.1) == (["uav2", "uav3"], "") and listener.others.warning == ""


def test_if_so_configured_nothing_is_flown_before_all_were_heard(monkeypatch):
    listener = Listener(monkeypatch, must_be_heard=True)
    listener.hear("uav2")
    assert listener.update(0.1) == (None, "not heard yet: uav3 (others/must_be_heard)")
    listener.hear("uav3")
    assert listener.update(0.1) == (["uav2", "uav3"], "")


def test_a_transform_that_nobody_tells_any_more_is_not_known(monkeypatch):
    listener = Listener(monkeypatch, max_transform_age_s=10.0, forget_after_s=0.0)
    listener.hear("uav2", "uav3")
    assert listener.update() == (["uav2", "uav3"], "")
    listener.tf_stamp_s = listener.now_s  # tf returns the newest one that it has, however old that is
    assert listener.update(9.0)[1] == ""
    others, problem = listener.update(2.0)
    assert others is None
    assert problem == ("where other UAVs are is not known: nobody has told its transform for more than 10.0 s")
    listener.tf_stamp_s = None
    assert listener.update(1.0) == (["uav2", "uav3"], "")


def test_a_lookup_that_fails_is_bridged_and_then_told(monkeypatch):
    listener = Listener(monkeypatch, max_transform_age_s=10.0, forget_after_s=0.0)
    listener.hear("uav2")
    assert listener.update() == (["uav2"], "")
    listener.tf_problem = "no transform from frame 'utm_origin'"
    assert listener.update(9.0) == (["uav2"], "")
    assert listener.update(2.0) == (None, "where other UAVs are is not known: no transform from frame 'utm_origin'")


def test_after_a_jump_of_the_odometry_they_are_not_placed_by_the_transform_before_it(monkeypatch):
    listener = Listener(monkeypatch)
    listener.hear("uav2")
    assert listener.update() == (["uav2"], "")
    listener.tf_stamp_s = listener.now_s
    listener.now_s += 0.5
    listener.others.odometry_jumped()
    assert "since the odometry jumped" in listener.update()[1]
    listener.tf_stamp_s = None
    assert listener.update(0.1) == (["uav2"], "")
