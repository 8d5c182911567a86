# SPDX-License-Identifier: BSD-3-Clause
"""The node's part of the way home: what it says of the battery and how often, and when it returns by itself."""

import types

import numpy as np
import pytest

import voxnav

pytest.importorskip("rospy", reason="rospy is not installed")
import rospy  # noqa: E402
from sensor_msgs.msg import BatteryState  # noqa: E402

from fake_flight import FakeFlight  # noqa: E402
from test_planning_manager import ORIGIN, START, world  # noqa: E402
from voxnav.nodes import planning_home  # noqa: E402
from voxnav.planning_manager import Because, Idle, Reason  # noqa: E402

CONFIG = dict(full_flight_time_s=600.0, reserve_s=60.0)


class Said:
    """Stands in for rospy: no topics and services, and logs that are kept."""

    def __init__(self, monkeypatch):
        self.warnings = []
        monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
        monkeypatch.setattr(rospy, "Service", lambda *_, **__: None)
        monkeypatch.setattr(rospy, "loginfo", lambda *_: None)
        monkeypatch.setattr(rospy, "logwarn", lambda text, *values: self.warnings.append(text % values))
        monkeypatch.setattr(rospy, "logwarn_throttle", lambda _, text, *values: None)
        monkeypatch.setattr(rospy, "logerr_throttle", lambda _, text, *values: self.warnings.append(text % values))


class Flight:
    """A vehicle that hovers 10 m from its start, whose node knows the way home."""

    def __init__(self, monkeypatch, **config):
        self.said, self.fake, self.goals = Said(monkeypatch), FakeFlight(world(), ORIGIN, START), []
        seam = types.SimpleNamespace(now=lambda: rospy.Time.from_sec(self.fake.now))
        self.home = planning_home.PlanningHome(voxnav.HomeConfig(**CONFIG, **config), self.fake.config,
                                               self.fake.manager, self.fake.map.view, self.set_goal, seam)
        self.fake.look()
        self.wait()
        assert self.fake.manager.set_goal((10.0, 0.0, 0.0), None, self.fake.now) == ""
        self.wait(15.0)
        assert np.linalg.norm(self.fake.position - (10.0, 0.0, 0.0)) < 0.8

    def set_goal(self, goal_W, heading_W):
        self.goals.append(np.array(goal_W))
        return self.fake.manager.set_goal(goal_W, heading_W, self.fake.now)

    def charge(self, percentage):
        self.home._on_battery(BatteryState(percentage=percentage))

    def wait(self, seconds=1.0, charge=None):
        def step(fake):
            if charge is not None:
                self.charge(charge)
            self.home.update(fake.now)
            return False
        self.fake.fly(seconds, step)


def test_an_unknown_charge_is_said_once_and_stands_in_the_diagnostics(monkeypatch):
    flight = Flight(monkeypatch)
    words = "nobody tells when to return: the charge of the battery is not known"
    flight.wait(20.0)
    assert flight.said.warnings.count(words) == 1 and flight.home.warning == words
    flight.wait(1.0, charge=0.9)
    assert flight.home.warning == ""
    flight.wait(20.0)
    assert flight.said.warnings.count(words) == 2, "the battery was heard in between, and is lost again"
    flight.wait(5.0, charge=float("nan"))
    assert flight.said.warnings[-1] == "nobody tells when to return: the charge of the battery is not measured"


def test_nothing_is_said_without_a_reserve(monkeypatch):
    flight = Flight(monkeypatch)
    flight.home._config = voxnav.HomeConfig()
    del flight.said.warnings[:]
    flight.wait(20.0)
    assert flight.said.warnings == [] and flight.home.warning == ""


def test_by_default_the_vehicle_does_not_return_by_itself(monkeypatch):
    flight = Flight(monkeypatch)
    flight.wait(10.0, charge=0.05)
    assert "return now" in flight.home.warning and flight.goals == []


def test_it_returns_by_itself_once_in_a_flight(monkeypatch):
    flight = Flight(monkeypatch, return_at_reserve=True)
    flight.wait(1.0, charge=0.5)
    assert flight.goals == []
    flight.wait(20.0, charge=0.05)
    assert len(flight.goals) == 1 and "returns to its start because of the battery" in flight.said.warnings
    assert np.linalg.norm(flight.fake.position) < 0.8
    assert flight.fake.manager.set_goal((3.0, 0.0, 0.0), None, flight.fake.now) == ""
    flight.wait(10.0, charge=0.05)
    assert len(flight.goals) == 1, "whoever sets another goal after that is not overridden"


@pytest.mark.parametrize("taken", ["by the control manager", "by another node"])
def test_it_does_not_take_the_vehicle_from_anybody(monkeypatch, taken):
    flight = Flight(monkeypatch, return_at_reserve=True)
    if taken == "by the control manager":
        flight.fake.is_repelling = True  # as remote control, it leaves the vehicle in the air and voxnav without it
    else:
        flight.fake.manager._state = Idle(Because(Reason.TAKEN_OVER, "goal dropped: somebody else flies"))
    flight.wait(2.0, charge=0.05)
    assert flight.goals == [] and "return now" in flight.home.warning


def test_a_return_that_is_refused_is_tried_again_and_said(monkeypatch):
    flight = Flight(monkeypatch, return_at_reserve=True)
    monkeypatch.setattr(flight.home, "_set_goal", lambda goal_W, heading_W: "goal is in the no-fly zone pond")
    flight.wait(1.0, charge=0.05)
    assert "no return because of the battery: goal is in the no-fly zone pond" in flight.said.warnings
    monkeypatch.setattr(flight.home, "_set_goal", flight.set_goal)
    flight.wait(1.0, charge=0.05)
    assert len(flight.goals) == 1


def test_the_goal_follows_the_start_when_the_map_is_corrected(monkeypatch):
    flight = Flight(monkeypatch)
    flight.home.correct_map({0: np.eye(4)}, np.eye(4), "odom")
    flight.wait(1.0)
    assert flight.home._serve_return(None).success
    moved = np.eye(4)
    moved[1, 3] = 2.0
    flight.home.correct_map({0: moved}, moved, "odom")
    flight.fake.T_W_O = moved
    flight.wait(15.0)
    assert len(flight.goals) == 2 and np.allclose(flight.goals[1] - flight.goals[0], (0.0, 2.0, 0.0), atol=1e-6)
    assert np.linalg.norm(flight.fake.position) < 0.8, "the start is where it was in the odometry frame"


def test_without_a_start_the_return_is_refused_with_the_reason(monkeypatch):
    flight = Flight(monkeypatch)
    flight.home.lose_map("the origins are not related")
    flight.wait(1.0)
    answer = flight.home._serve_return(None)
    assert not answer.success and answer.message == "no start is known: the map was closed: the origins are not related"
