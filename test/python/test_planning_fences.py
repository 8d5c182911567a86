# SPDX-License-Identifier: BSD-3-Clause
"""The planning manager keeps a simulated vehicle within its fences, and tells which fence keeps it from flying."""

import numpy as np
import pytest

import voxnav
from fake_flight import FakeFlight
from test_planning_manager import IDLE, WALL, moving, reached, started, world
from voxnav.fences import PlacedFences
from voxnav.planning_manager import Reason

GOAL = (25.0, 0.0, 0.0)
START = (0.0, 0.0, 0.0)


def prism(corners, low=-5.0, high=10.0):
    return voxnav.Prism(np.array(corners, dtype=float), low, high)


def box(x0, y0, x1, y1, low=-5.0, high=10.0):
    return prism([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], low, high)


def fence(flight, area=None, **zones):
    """Sets the fences of a flight, as the node does."""
    fences = voxnav.Fences(area, list(zones.values()))
    flight.map.set_fences(fences)
    flight.manager.set_fences(PlacedFences(fences, tuple(zones), np.zeros(0), 1))
    return fences


def reason(flight):
    return flight.manager.status.because.reason


def fenced(truth=None, area=None, **zones):
    flight = FakeFlight(world() if truth is None else truth, (-4.0, -10.0, -4.0), START)
    flight.look()
    flight.tell()
    fences = fence(flight, area, **zones)
    return flight, fences


def violations(flight, fences, radius_m=0.0):
    return [p for p in flight.track if fences.contact(p, radius_m) is not None]


def test_flies_round_a_zone_that_cuts_the_straight_way():
    flight, fences = fenced(mast=box(10.0, -4.0, 14.0, 3.0))
    assert flight.manager.set_goal(GOAL, None, flight.now) == ""
    assert flight.fly(60.0, reached), flight.manager.status
    assert not violations(flight, fences, radius_m=0.6)
    assert max(abs(p[1]) for p in flight.track) > 3.0 and flight.count("hover") == 0


def test_flies_over_a_low_zone_and_under_a_high_one():
    flight, fences = fenced(low=box(6.0, -11.0, 10.0, 11.0, -5.0, -0.5), high=box(16.0, -11.0, 20.0, 11.0, 1.0, 10.0))
    assert flight.manager.set_goal(GOAL, None, flight.now) == ""
    assert flight.fly(60.0, reached), flight.manager.status
    assert not violations(flight, fences, radius_m=0.6)


def test_flies_within_an_area_that_cuts_the_straight_way():
    around = prism([(-3, -3), (9, -3), (9, 6), (16, 6), (16, -3), (28, -3), (28, 9), (-3, 9)])
    flight, fences = fenced(area=around)
    assert flight.manager.set_goal(GOAL, None, flight.now) == ""
    assert flight.fly(60.0, reached), flight.manager.status
    assert not violations(flight, fences)
    assert max(p[1] for p in flight.track) > 6.0


def test_a_wall_and_an_area_that_leave_no_way_end_with_a_reason():
    flight, fences = fenced(truth=world(WALL), area=box(-3.0, -2.5, 28.0, 2.5, -3.0, 3.0))
    assert flight.manager.set_goal(GOAL, None, flight.now) == ""
    flight.fly(60.0, lambda f: f.manager.status.goal_W is None)
    assert not reached(flight) and not violations(flight, fences)
    assert reason(flight) in (Reason.GOAL_ENCLOSED, Reason.NO_WAY)


@pytest.mark.parametrize("goal, expected, words", [
    ((25.0, 0.0, 0.0), Reason.GOAL_OUTSIDE_AREA, "goal is outside the safety area"),
    ((5.0, 0.0, 4.5), Reason.GOAL_OUTSIDE_AREA, "goal is outside the safety area"),
    ((8.0, 3.0, 0.0), Reason.GOAL_IN_ZONE, "goal is in the no-fly zone mast")])
def test_a_goal_beyond_a_fence_is_refused_at_once(goal, expected, words):
    flight, _ = fenced(area=box(-3.0, -5.0, 20.0, 5.0, -3.0, 4.0), mast=box(7.0, 2.0, 9.0, 4.0))
    assert flight.manager.set_goal(goal, None, flight.now) == words
    assert flight.manager.status.refusal.reason is expected
    assert flight.manager.status.state == IDLE and flight.manager.status.goal_W is None
    flight.fly(2.0)
    assert np.linalg.norm(flight.position) == 0.0
    assert flight.manager.set_goal((5.0, 0.0, 0.0), None, flight.now) == ""
    assert flight.manager.status.refusal is None


def test_a_refused_goal_leaves_the_one_before():
    flight, _ = fenced(area=box(-3.0, -5.0, 28.0, 5.0))
    assert flight.manager.set_goal(GOAL, None, flight.now) == ""
    assert flight.fly(10.0, moving)
    assert flight.manager.set_goal((0.0, 9.0, 0.0), None, flight.now) != ""
    assert flight.fly(60.0, reached)


def test_the_goal_of_the_map_frame_is_compared_with_fences_of_the_odometry_frame():
    shift = np.eye(4)
    shift[:3, 3] = (100.0, 0.0, 0.0)
    flight = started(world(), (110.0, 0.0, 0.0), T_W_O=shift)
    fence(flight, area=box(-3.0, -5.0, 20.0, 5.0))
    assert flight.manager.set_goal((110.0, 1.0, 0.0), None, flight.now) == ""
    assert flight.manager.set_goal((10.0, 1.0, 0.0), None, flight.now) == "goal is outside the safety area"


@pytest.mark.parametrize("kwargs, words", [
    ({"area": box(5.0, -5.0, 28.0, 5.0)}, "the vehicle is outside the safety area"),
    ({"area": box(-3.0, -5.0, 28.0, 5.0, 1.0, 5.0)}, "the vehicle is outside the safety area"),
    ({"mast": box(-1.0, -1.0, 1.0, 1.0)}, "the vehicle is in the no-fly zone mast")])
def test_a_vehicle_outside_its_fences_stays_where_it_is(kwargs, words):
    flight, _ = fenced(**kwargs)
    assert flight.manager.set_goal((10.0, 0.0, 2.0), None, flight.now) == ""
    flight.fly(10.0)
    assert np.linalg.norm(flight.position) == 0.0 and flight.count("publish") == 0
    assert reason(flight) is Reason.FENCED and words in flight.manager.status.reason
    # The flight resumes when the fences allow it.
    fence(flight)
    assert flight.fly(60.0, reached), flight.manager.status


def test_nothing_is_flown_while_the_fences_are_not_known():
    flight, _ = fenced()
    flight.manager.set_fences(None, "fences cannot be placed: safety_area: no transform from frame 'world_origin'")
    assert flight.manager.set_goal(GOAL, None, flight.now) == ""
    flight.fly(5.0)
    assert np.linalg.norm(flight.position) == 0.0
    assert reason(flight) is Reason.FENCES_UNKNOWN and "no transform" in flight.manager.status.reason
    fence(flight, area=box(-3.0, -5.0, 28.0, 5.0))
    assert flight.fly(60.0, reached), flight.manager.status


def test_a_vehicle_at_the_edge_of_its_area_comes_in():
    flight, fences = fenced(area=box(-0.1, -5.0, 28.0, 5.0))
    assert flight.manager.set_goal((10.0, 0.0, 0.0), None, flight.now) == ""
    assert flight.fly(60.0, reached), flight.manager.status
    assert not violations(flight, fences)


def test_a_zone_that_appears_on_the_way_is_flown_round():
    flight, _ = fenced()
    assert flight.manager.set_goal(GOAL, None, flight.now) == ""
    assert flight.fly(20.0, lambda f: f.position[0] > 4.0)
    fences = fence(flight, mast=box(14.0, -4.0, 17.0, 3.0))
    assert flight.fly(60.0, reached), flight.manager.status
    assert not violations(flight, fences, radius_m=0.5)
    assert any("in a no-fly zone" in sentence for _, sentence in flight.log)


def test_a_zone_over_the_goal_drops_the_goal():
    flight, _ = fenced()
    assert flight.manager.set_goal(GOAL, None, flight.now) == ""
    assert flight.fly(20.0, lambda f: f.position[0] > 4.0)
    fences = fence(flight, mast=box(22.0, -4.0, 28.0, 4.0))
    assert flight.fly(30.0, lambda f: f.manager.status.goal_W is None)
    assert reason(flight) is Reason.GOAL_FENCED
    flight.fly(5.0)
    assert not violations(flight, fences, radius_m=0.5)


def test_an_area_that_shrinks_stops_the_vehicle_inside():
    flight, _ = fenced(area=box(-3.0, -5.0, 28.0, 5.0))
    assert flight.manager.set_goal(GOAL, None, flight.now) == ""
    assert flight.fly(20.0, lambda f: f.position[0] > 4.0)
    fences = fence(flight, area=box(-3.0, -5.0, 12.0, 5.0))
    assert flight.fly(30.0, lambda f: f.manager.status.goal_W is None)
    flight.fly(5.0)
    assert not violations(flight, fences)


def test_somebody_who_flies_out_of_the_area_is_told():
    flight, _ = fenced(area=box(-3.0, -5.0, 6.0, 5.0))
    points = np.linspace((0.0, 0.0, 0.0), (12.0, 0.0, 0.0), 41)
    flight.flown = (points, 0.2, flight.now)
    flight.fly(4.0, lambda f: reason(f) is Reason.OTHERS_UNSAFE)
    assert "outside the safety area" in flight.manager.status.reason
    assert flight.count("hover") == 0


@pytest.mark.parametrize("goal", [(12.0, 4.9, 0.0), (12.0, -4.7, 0.0), (12.0, 0.0, 3.9)])
def test_a_goal_at_the_edge_of_the_area_is_flown_to_as_near_as_planned_paths_go(goal):
    flight, fences = fenced(area=box(-3.0, -5.0, 28.0, 5.0, -3.0, 4.0))
    assert flight.manager.set_goal(goal, None, flight.now) == ""
    assert flight.fly(60.0, lambda f: f.manager.status.goal_W is None)
    assert reason(flight) in (Reason.REACHED, Reason.GOAL_BLOCKED)
    assert np.linalg.norm(flight.position - goal) < 1.3
    assert not violations(flight, fences)
