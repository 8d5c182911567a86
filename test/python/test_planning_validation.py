# SPDX-License-Identifier: BSD-3-Clause
"""Goals are shown to the control manager, whose refusal drops them unless it is about a way that is not flown."""

import types

import numpy as np
import pytest

import voxnav

pytest.importorskip("rospy", reason="rospy is not installed")
import rospy  # noqa: E402

from test_planning_manager import moving, reached, started, world  # noqa: E402
from voxnav.fences.placing import PlacedFences  # noqa: E402
from voxnav.nodes import planning_validation  # noqa: E402
from voxnav.nodes.planning_services import ServiceError  # noqa: E402
from voxnav.planning_manager import Because, Reason  # noqa: E402
from voxnav.planning_manager.inputs import Fencing  # noqa: E402

# An area in the shape of a U, so that the straight way between its tips leaves it.
U = [[0, 0], [30, 0], [30, 20], [20, 20], [20, 5], [10, 5], [10, 20], [0, 20]]
LEFT, RIGHT, BETWEEN = (5.0, 15.0, 2.0), (25.0, 15.0, 2.0), (15.0, 15.0, 2.0)


def fencing():
    area = voxnav.Prism(np.array(U, dtype=float), -10.0, 20.0)
    return Fencing(PlacedFences(voxnav.Fences(area, []), (), np.zeros(0), 1))


class Asked:
    """A GoalValidation whose service answers as it is told, and what became of its goals."""

    def __init__(self, monkeypatch, answer, fences=Fencing(), **config):
        self.requests, self.refused, self.answer = [], [], answer
        monkeypatch.setattr(planning_validation, "TimedService", lambda *_: self)
        monkeypatch.setattr(rospy, "logwarn", lambda *_: None)
        monkeypatch.setattr(rospy, "loginfo", lambda *_: None)
        self.inputs = types.SimpleNamespace(T_W_O=np.eye(4), odometry_frame="uav1/gps_origin",
                                            position_O=np.array(LEFT))
        seam = types.SimpleNamespace(executor=lambda name, run: types.SimpleNamespace(
            submit=lambda item: (run(item) or (lambda: None))()))
        self.validation = planning_validation.GoalValidation(
            voxnav.PlanningNodeConfig(**config), self.inputs, lambda: fences,
            lambda goal_W, because: self.refused.append((goal_W, because)), seam)

    def call(self, request):
        self.requests.append(request.reference)
        if isinstance(self.answer, ServiceError):
            raise self.answer
        return types.SimpleNamespace(success=self.answer == "", message=self.answer)

    def set_goal(self, goal_W, heading_W=None):
        self.validation.set_goal(goal_W, heading_W)
        for _ in range(5):
            self.validation.update()
        return self


def test_each_goal_is_shown_once_in_the_frame_of_the_control_manager(monkeypatch):
    asked = Asked(monkeypatch, "")
    asked.inputs.T_W_O = voxnav.pose_from_quaternion((10.0, 0.0, 1.0), (0.0, 0.0, np.sin(0.25), np.cos(0.25)))
    asked.set_goal(RIGHT, 0.7)
    [shown] = asked.requests
    assert shown.header.frame_id == "uav1/gps_origin" and shown.reference.heading == pytest.approx(0.2)
    p = shown.reference.position
    assert np.allclose(asked.inputs.T_W_O @ (p.x, p.y, p.z, 1.0), RIGHT + (1.0,))
    assert asked.refused == [] and asked.validation.problem == ""


def test_it_waits_until_the_place_of_the_goal_is_known(monkeypatch):
    asked = Asked(monkeypatch, "")
    asked.inputs.T_W_O = None
    assert asked.set_goal(RIGHT).requests == []
    asked.inputs.T_W_O = np.eye(4)
    asked.validation.update()
    assert len(asked.requests) == 1


def test_a_refusal_has_the_reason_of_the_control_manager(monkeypatch):
    asked = Asked(monkeypatch, "the point is outside of the safety area").set_goal(RIGHT)
    [(goal_W, because)] = asked.refused
    assert tuple(goal_W) == RIGHT and because.reason is Reason.GOAL_REFUSED
    assert because.sentence == "the control manager refuses the goal: the point is outside of the safety area"
    assert asked.validation.num_refused == 1


def test_a_service_that_is_absent_is_told_and_the_goal_stands(monkeypatch):
    asked = Asked(monkeypatch, ServiceError("service [/uav1/validate] unavailable")).set_goal(RIGHT)
    assert asked.refused == []
    assert asked.validation.problem == ("the control manager was not asked about the goal: service [/uav1/validate] "
                                        "unavailable")
    asked.answer = ""
    assert asked.set_goal(LEFT).validation.problem == ""


def test_a_straight_way_that_is_not_flown_is_no_reason_to_refuse(monkeypatch):
    words = "the path is going outside the safety area"
    assert Asked(monkeypatch, words, fencing()).set_goal(RIGHT).refused == []
    assert len(Asked(monkeypatch, words, fencing()).set_goal((25.0, 3.0, 2.0)).refused) == 0
    assert len(Asked(monkeypatch, words, fencing()).set_goal((8.0, 15.0, 2.0)).refused) == 1, "the way is inside"
    assert len(Asked(monkeypatch, words, fencing()).set_goal(BETWEEN).refused) == 1, "the goal is outside"
    assert len(Asked(monkeypatch, words).set_goal(RIGHT).refused) == 1, "voxnav knows no area to fly round"


def test_nothing_is_asked_if_that_is_configured(monkeypatch):
    assert Asked(monkeypatch, "no", validate_goals=False).set_goal(RIGHT).requests == []


# What the manager makes of a refusal

BECAUSE = Because(Reason.GOAL_REFUSED, "the control manager refuses the goal: for the test")
GOAL = (25.0, 0.0, 0.0)


def test_a_refused_goal_is_dropped_at_once_and_a_vehicle_in_flight_stops():
    flight = started(world(), GOAL)
    assert flight.fly(5.0, lambda f: moving(f) and f.position[0] > 2.0)
    flight.do(flight.manager.refuse_goal(np.array(GOAL), BECAUSE, flight.now))
    status = flight.manager.status
    assert status.goal_W is None and status.refusal is BECAUSE and status.because.reason is Reason.GOAL_REFUSED
    assert status.reason == "goal dropped: the control manager refuses the goal: for the test"
    flight.fly(5.0)
    assert flight.count("hover") >= 1 and np.linalg.norm(flight.velocity) < 0.01 and flight.position[0] < 12.0


def test_a_vehicle_that_does_not_move_yet_is_told_nothing():
    flight = started(world(), GOAL)
    assert flight.manager.refuse_goal(np.array(GOAL), BECAUSE, flight.now) == []
    assert flight.manager.status.goal_W is None


def test_a_refusal_of_an_earlier_goal_does_not_count():
    flight = started(world(), GOAL)
    assert flight.manager.set_goal((20.0, 3.0, 0.0), None, flight.now) == ""
    assert flight.manager.refuse_goal(np.array(GOAL), BECAUSE, flight.now) == []
    assert flight.fly(40.0, reached)
