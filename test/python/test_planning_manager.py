# SPDX-License-Identifier: BSD-3-Clause
"""The planning manager flies a simulated vehicle to its goals and reacts to faults with a reason."""

import numpy as np
import pytest

import voxnav
from fake_flight import TICK_S, FakeFlight
from voxnav.planning_manager import Control, Means, Reason

IDLE, PLANNING, MOVING = 0, 1, 2
SIZE = (110, 50, 20)
ORIGIN = (-4.0, -10.0, -4.0)
START = (0.0, 0.0, 0.0)
GROUNDED = Control(is_flying=False, accepts_goals=False, is_tracking=False)


def world(*boxes):
    """Returns free space with occupied boxes, each given by its lowest and highest corner in metres in O."""
    truth = np.ones(SIZE, dtype=np.int8)
    for low, high in boxes:
        a = np.floor((np.array(low) - ORIGIN) / 0.4).astype(int)
        b = np.ceil((np.array(high) - ORIGIN) / 0.4).astype(int)
        a, b = np.maximum(a, 0), np.maximum(b, 0)
        truth[a[0]:b[0], a[1]:b[1], a[2]:b[2]] = 2
    return truth


WALL = ((12.0, -3.0, -4.0), (13.0, 3.0, 4.0))


def started(truth, goal, **kwargs):
    flight = FakeFlight(truth, ORIGIN, START, **kwargs)
    flight.look()
    flight.tell()
    assert flight.manager.set_goal(goal, None, flight.now) == ""
    return flight


def reached(flight):
    return flight.manager.status["is_goal_reached"]


def moving(flight):
    return flight.manager.status["state"] == MOVING


def test_flies_around_an_unseen_wall_to_the_goal():
    flight = started(world(WALL), (25.0, 0.0, 0.0), known_range_m=8.0)
    assert flight.fly(60.0, reached), flight.manager.status
    assert flight.manager.status["state"] == IDLE
    assert "goal reached" in flight.manager.status["reason"]
    assert np.linalg.norm(flight.position - (25.0, 0.0, 0.0)) < 0.8
    assert flight.clearance() > 0.5
    assert flight.count("hover") == 0


def test_goal_is_kept_in_the_map_frame():
    shift = np.eye(4)
    shift[:3, 3] = (2.0, 1.0, 0.5)
    flight = started(world(), (20.0, 2.0, 1.0), T_W_O=shift)
    assert flight.fly(5.0, moving)
    corrected = shift.copy()
    corrected[:3, 3] = (3.0, 0.0, 0.5)  # the graph corrects the map during the flight
    flight.T_W_O = corrected
    assert flight.fly(40.0, reached), flight.manager.status
    assert np.linalg.norm(flight.position - (17.0, 2.0, 0.5)) < 0.8


def test_an_obstacle_that_appears_shortens_the_trajectory_and_the_flight_goes_on():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.truth = world(WALL)
    flight.look()
    assert flight.fly(60.0, reached), flight.manager.status
    assert flight.manager.status["num_shortened"] >= 1
    assert flight.clearance() > 0.5


def test_an_obstacle_too_near_to_stop_before_makes_it_brake():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 8.0)
    box = ((flight.position[0] + 1.4, -3.0, -4.0), (flight.position[0] + 2.4, 3.0, 4.0))
    flight.truth = world(box)
    flight.look()
    flight.fly(0.2)
    assert flight.log[-1][0] in ("hover", "plan", "generate", "publish")
    assert any(kind == "hover" and reason.startswith("brake") for kind, reason in flight.log)
    assert flight.fly(60.0, reached), flight.manager.status


@pytest.mark.parametrize("what, words", [("map", "local map lost"), ("odometry", "odometry lost"),
                                         ("tracker", "tracker prediction lost"), ("correction", "map correction lost")])
def test_a_lost_input_leads_to_hover_with_a_reason_and_the_flight_resumes(what, words):
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.lost.add(what)
    flight.fly(4.0)
    status = flight.manager.status
    assert status["state"] == IDLE and words in status["reason"] and status["goal_W"] is not None
    assert flight.count("hover") == 1
    assert np.linalg.norm(flight.velocity) == 0.0
    flight.lost.clear()
    assert flight.fly(60.0, reached), flight.manager.status


def test_a_lost_node_leads_to_hover_and_the_flight_resumes():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, moving)
    flight.manager.set_lost_nodes(["submap_integrator"])
    flight.fly(1.0)
    assert flight.manager.status["reason"] == "hover: submap_integrator is not running"
    flight.manager.set_lost_nodes([])
    assert flight.fly(60.0, reached)


@pytest.mark.parametrize("kind, words", [("generate", "trajectory generator: refused"),
                                         ("publish", "trajectory refused")])
def test_a_refusing_service_is_named_and_tried_again(kind, words):
    flight = started(world(), (10.0, 0.0, 0.0))
    flight.fails.add(kind)
    flight.fly(3.0)
    assert words in flight.manager.status["reason"]
    assert np.array_equal(flight.position, START)
    flight.fails.clear()
    assert flight.fly(30.0, reached)


@pytest.mark.parametrize("kind", ["plan", "generate", "publish"])
def test_a_service_that_never_answers_is_named_and_tried_again(kind):
    flight = started(world(), (10.0, 0.0, 0.0))
    flight.silent.add(kind)
    flight.fly(5.0)
    assert "does not answer" in flight.manager.status["reason"]
    flight.silent.clear()
    assert flight.fly(30.0, reached)


@pytest.mark.parametrize("kind", ["plan", "generate", "publish"])
def test_an_action_that_cannot_be_executed_is_named_at_once_and_tried_again(kind):
    flight = started(world(), (10.0, 0.0, 0.0))
    flight.broken.add(kind)
    flight.fly(0.2)
    assert "broken for the test" in flight.manager.status["reason"]
    flight.broken.clear()
    assert flight.fly(30.0, reached)


def test_a_hover_that_cannot_be_executed_is_tried_again():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, moving)
    flight.broken.add("hover")
    flight.do(flight.manager.stop("stopped by the user", flight.now))
    assert "broken for the test" in flight.manager.status["reason"] and flight.flown is not None
    flight.broken.clear()
    flight.fly(2.0)
    assert flight.flown is None


def test_hover_is_repeated_until_it_is_accepted():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, moving)
    flight.fails.add("hover")
    flight.do(flight.manager.stop("stopped by the user", flight.now))
    flight.fly(3.5)
    assert flight.count("hover") >= 3
    flight.fails.clear()
    flight.fly(2.0)
    hovers = flight.count("hover")
    flight.fly(3.0)
    assert flight.count("hover") == hovers
    assert flight.manager.status["state"] == IDLE
    assert flight.manager.status["goal_W"] is None


def test_a_hover_refused_in_motion_becomes_an_emergency_hover_at_once():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.fails.add(Means.HOVER)
    flight.do(flight.manager.stop("stopped by the user", flight.now))
    assert flight.flown is None, "the vehicle has stopped before the next tick"
    assert flight.count("hover") == 2
    assert flight.manager.status.num_hovers == 1


def climbed(flight, height_m, speed_mps=1.0):
    """Moves the vehicle away from where the tracker believes it to be, in small steps."""
    while abs(flight.shift[2] - height_m) > 1e-6:
        change = height_m - flight.shift[2]
        flight.shift[2] += np.clip(change, -speed_mps * TICK_S, speed_mps * TICK_S)
        flight.step()


def test_a_vehicle_that_somebody_lifts_by_three_metres_flies_on_with_new_plans():
    # The mutual avoidance of the control manager climbs 3 m while it follows the trajectory.
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 2.0)
    plans = flight.count("plan")
    climbed(flight, 3.0)
    assert "from the trajectory" in flight.manager.status.reason or moving(flight)
    assert flight.count("plan") > plans
    climbed(flight, 0.0)
    assert flight.count("hover") == 0
    assert flight.fly(60.0, reached), flight.manager.status


def test_a_vehicle_that_leaves_its_trajectory_altogether_is_stopped():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 2.0)
    climbed(flight, 4.0)
    assert any(kind == "hover" and reason.startswith("brake: 3.") for kind, reason in flight.log), flight.log


def test_a_jump_of_the_odometry_stops_the_flight_and_it_resumes():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.shift[1] = 2.0
    velocity = flight.velocity
    flight.position = flight.position + (0.0, 2.0, 0.0)
    flight.manager.set_vehicle(flight.now + 0.01, flight.position, velocity)
    flight.do(flight.manager.tick(flight.now + 0.01))
    assert ("hover", "odometry jumped by 2.0 m") in flight.log
    flight.shift[1] = 0.0
    assert flight.fly(60.0, reached), flight.manager.status


@pytest.mark.parametrize("limits, words", [
    ([0.0] * 6, "not between"), ([-4.0, 2.0, 2.0, 1.0, 2.0, 1.0], "not between"),
    ([float("nan")] * 6, "not finite"), ([1e9] * 6, "not between"), ([4.0, 2.0, 2.0, 1e-6, 2.0, 1.0], "not between")])
def test_absurd_limits_stop_the_flight_with_a_reason_and_it_resumes(limits, words):
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.limits = limits
    flight.fly(0.3)
    status = flight.manager.status
    assert "constraints" in status.reason and words in status.reason and status.goal_W is not None
    assert flight.count("hover") == 1 and flight.flown is None
    flight.limits = None
    assert flight.fly(60.0, reached), flight.manager.status


@pytest.mark.parametrize("what", ["map", "odometry", "tracker"])
def test_stamps_of_another_clock_stop_the_flight_with_a_reason(what):
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.ahead_s[what] = 30.0
    flight.fly(0.3)
    assert "stamped in the future" in flight.manager.status.reason and flight.count("hover") == 1
    flight.ahead_s.clear()
    assert flight.fly(60.0, reached), flight.manager.status


def test_predictions_that_are_none_count_as_lost():
    manager = voxnav.PlanningManager(voxnav.PlanningManagerConfig(), (0.5, 20.0), lambda: None)
    for times, places in (([1.0, 0.5], np.zeros((2, 3))), ([1.0], np.zeros((2, 3))), ([], np.zeros((0, 3))),
                          ([1.0, 2.0], np.full((2, 3), np.nan)), ([1.0, 2.0], np.zeros((2, 2)))):
        manager.set_prediction(0.0, times, places)
        assert manager.inputs.prediction is None
    manager.set_prediction(0.0, [1.0, 2.0], np.zeros((2, 3)))
    assert manager.inputs.prediction is not None


def test_a_slow_generator_makes_no_step_back():
    flight = started(world(), (30.0, 0.0, 0.0), known_range_m=6.0)
    flight.delay_s = 0.4
    assert flight.fly(60.0, reached), flight.manager.status
    moves = np.diff(flight.track, axis=0)
    assert np.linalg.norm(moves, axis=1).max() < 0.12, "1.5 m/s and no jump"
    assert moves[:, 0].min() > -1e-6, "no trajectory begins behind the vehicle"
    assert flight.count("publish") > 4 and flight.count("hover") == 0


def test_a_generator_that_answers_when_its_trajectory_is_over_is_named():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.delay_s = 100.0
    flight.fly(3.0)
    assert flight.count("hover") == 0
    flight.delay_s = 0.0
    assert flight.fly(60.0, reached), flight.manager.status


def test_a_stop_on_the_ground_does_not_wait_for_a_hover():
    flight = FakeFlight(world(), ORIGIN, START)
    flight.look()
    flight.tell()
    flight.fails.add("hover")
    flight.manager.set_control(flight.now, GROUNDED)
    flight.do(flight.manager.stop("stopped by the user", flight.now))
    flight.manager.set_control(flight.now + 1.0, GROUNDED)
    assert flight.manager.tick(flight.now + 1.0) == []
    assert flight.manager.set_goal((10.0, 0.0, 0.0), None, flight.now + 1.0) == ""
    flight.now += 1.0
    assert flight.fly(30.0, reached), flight.manager.status


def given_up(flight):
    return flight.manager.status.goal_W is None


def reason(flight):
    return flight.manager.status.because.reason


def test_goal_inside_an_obstacle_ends_near_it_with_a_reason_after_two_plans():
    flight = started(world(((18.0, -2.0, -4.0), (20.0, 2.0, 4.0))), (19.0, 0.0, 0.0))
    assert flight.fly(60.0, given_up), flight.manager.status
    status = flight.manager.status
    assert not status["is_goal_reached"] and reason(flight) is Reason.GOAL_BLOCKED
    assert "goal cannot be reached" in status["reason"] and "obstacle" in status["reason"]
    assert 0.9 < np.linalg.norm(flight.position - (19.0, 0.0, 0.0)) < 4.0
    assert flight.count("plan") == 2


def test_a_goal_beside_the_vehicle_in_an_obstacle_is_refused_after_one_plan():
    flight = started(world(((2.0, -1.0, -4.0), (3.0, 1.0, 4.0))), (2.4, 0.0, 0.0))
    assert flight.fly(10.0, given_up), flight.manager.status
    assert reason(flight) is Reason.GOAL_BLOCKED and flight.count("plan") <= 2


def test_the_same_blocked_goal_gets_the_same_answer_from_everywhere():
    sentences = set()
    for start in ((0.0, 0.0, 0.0), (10.0, 7.0, 2.0), (30.0, -6.0, -1.0)):
        flight = FakeFlight(world(((18.0, -2.0, -4.0), (20.0, 2.0, 4.0))), ORIGIN, start)
        flight.look()
        flight.tell()
        for _ in range(3):
            assert flight.manager.set_goal((19.0, 0.0, 0.0), None, flight.now) == ""
            assert flight.fly(60.0, given_up), flight.manager.status
            sentences.add((reason(flight), flight.manager.status.reason))
    assert len(sentences) == 1, sentences


def room(low, high):
    """Returns a closed box of walls, 0.8 m thick."""
    a, b = np.array(low), np.array(high)
    boxes = []
    for axis in range(3):
        for end in (a, b):
            p, q = a.copy(), b + 0.8
            p[axis], q[axis] = end[axis], end[axis] + 0.8
            boxes.append((p, q))
    return boxes


def test_a_goal_in_a_closed_room_is_answered():
    flight = started(world(*room((14.0, -3.0, -3.6), (22.0, 4.0, 2.0))), (18.4, 0.6, -0.8))
    assert flight.fly(60.0, given_up), flight.manager.status
    assert reason(flight) is Reason.GOAL_ENCLOSED, flight.manager.status
    assert flight.now - 100.0 < 20.0


def test_a_goal_below_the_ground_is_answered_after_two_plans():
    truth = world()
    truth[:, :, :5] = 0
    truth[:, :, 3:5] = 2  # the ground is at -2 m, and nothing below it is ever seen
    flight = started(truth, (10.0, 0.0, -3.8))
    assert flight.fly(30.0, given_up), flight.manager.status
    assert reason(flight) is Reason.GOAL_BELOW_GROUND and flight.count("plan") == 2


def test_a_goal_outside_the_map_is_flown_to_in_parts():
    flight = FakeFlight(world(), ORIGIN, START, known_range_m=12.0, map_range_m=15.0)
    flight.look()
    flight.tell()
    assert flight.manager.set_goal((36.0, 4.0, 0.0), None, flight.now) == ""
    assert flight.fly(5.0, moving)
    assert reason(flight) is Reason.GOAL_OUTSIDE_MAP, flight.manager.status
    assert flight.fly(60.0, reached), flight.manager.status
    assert flight.count("hover") == 0


def test_a_goal_that_turns_out_to_be_blocked_is_answered_within_a_second():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 8.0)
    assert reason(flight) is Reason.MOVING
    flight.truth = world(((23.0, -2.0, -4.0), (27.0, 2.0, 4.0)))
    flight.look()
    assert flight.fly(1.0, lambda f: reason(f) is Reason.GOAL_BLOCKED), flight.manager.status
    assert moving(flight), "it flies to the nearest place"
    assert flight.fly(60.0, given_up) and reason(flight) is Reason.GOAL_BLOCKED


def test_a_goal_that_changes_every_second_causes_no_hover_and_no_stop():
    rng = np.random.RandomState(5)
    flight = started(world(WALL), (25.0, 0.0, 0.0))
    assert flight.fly(5.0, moving)
    speeds = []
    for _ in range(25):
        goal = rng.uniform((0.0, -7.0, -1.0), (30.0, 7.0, 1.0))
        flight.manager.set_goal(goal, None, flight.now)
        flight.fly(1.0)
        speeds.append(np.linalg.norm(flight.velocity))
    assert flight.count("hover") == 0 and flight.clearance() > 0.5
    assert np.median(speeds) > 1.0
    assert flight.manager.set_goal((25.0, 4.0, 0.0), None, flight.now) == ""
    assert flight.fly(60.0, reached), flight.manager.status


def test_a_goal_a_little_too_near_to_an_obstacle_is_reached_within_its_tolerance():
    # The goal is 0.7 m before the box, less than the safety distance; a place 0.5 m before it is within the tolerance.
    flight = started(world(((12.0, -1.0, -1.0), (13.0, 1.0, 1.0))), (11.3, 0.0, 0.0))
    assert flight.fly(40.0, reached), flight.manager.status
    assert 0.1 < np.linalg.norm(flight.position - (11.3, 0.0, 0.0)) <= 0.8
    assert flight.clearance() > 0.9


def test_an_enclosed_vehicle_is_reported_stuck():
    flight = started(world(((2.0, -10.0, -4.0), (3.0, 10.0, 4.0))), (20.0, 0.0, 0.0), stuck_time_s=5.0)
    assert flight.fly(60.0, lambda f: f.manager.status["goal_W"] is None)
    assert flight.manager.status["reason"].startswith("stuck: ")
    assert flight.position[0] < 1.6


def test_nothing_is_flown_into_unknown_space():
    flight = started(world(), (25.0, 0.0, 0.0), known_range_m=6.0, stuck_time_s=4.0)
    flight.lost.add("look")
    flight.look = lambda: None  # the map learns nothing more, but its stamp stays recent
    assert flight.fly(60.0, lambda f: f.manager.status["goal_W"] is None)
    assert "unknown" in flight.manager.status["reason"]
    assert flight.position[0] < 6.0


def test_unusable_goals_are_refused_with_a_reason():
    manager = voxnav.PlanningManager(voxnav.PlanningManagerConfig(), (0.5, 20.0), lambda: None)
    assert manager.set_goal((float("nan"), 0.0, 2.0), None, 0.0) == "goal is not finite"
    assert manager.set_goal((1.0, 0.0, 2.0), float("inf"), 0.0) == "goal is not finite"
    assert "below" in manager.set_goal((1.0, 0.0, -3.0), None, 0.0)
    assert "above" in manager.set_goal((1.0, 0.0, 30.0), None, 0.0)
    assert "100 km" in manager.set_goal((1e9, 0.0, 2.0), None, 0.0)
    assert manager.status["goal_W"] is None
    assert manager.tick(0.1) == []


def test_a_clock_that_jumps_back_leads_to_hover_and_recovery():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, moving)
    flight.now -= 50.0
    flight.flown = (flight.flown[0], flight.flown[1], flight.flown[2] - 50.0)
    flight.step()
    assert flight.count("hover") == 1
    assert "clock jumped back" in flight.log[-1][1]
    assert flight.fly(60.0, reached), flight.manager.status


def test_a_new_goal_in_flight_replaces_the_old_one():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 5.0)
    assert flight.manager.set_goal((0.0, 8.0, 0.0), None, flight.now) == ""
    assert flight.fly(60.0, reached), flight.manager.status
    assert np.linalg.norm(flight.position - (0.0, 8.0, 0.0)) < 0.8


def assert_dropped(flight, words):
    """Asserts that the goal was dropped with a reason, voxnav commands nothing, and a new goal is flown to."""
    status = flight.manager.status
    assert status["goal_W"] is None and not status["is_goal_reached"] and status["state"] == IDLE
    assert status["reason"].startswith("goal dropped: ") and words in status["reason"]
    num_commands = len(flight.log)
    flight.is_flying = True
    flight.fly(5.0)
    assert len(flight.log) == num_commands
    assert flight.manager.set_goal((10.0, 4.0, 0.0), None, flight.now) == ""
    assert flight.fly(60.0, reached), flight.manager.status


def test_a_hover_commanded_by_another_node_drops_the_goal():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.hover()
    flight.fly(0.3)
    assert flight.count("hover") == 0
    assert_dropped(flight, "somebody else let the vehicle hover")


def test_a_landing_drops_the_goal():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.flown, flight.is_flying = None, False
    flight.fly(0.3)
    assert_dropped(flight, "landed")


def test_a_landing_during_a_hover_of_voxnav_drops_the_goal():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.lost.add("map")
    flight.fly(2.0)
    assert flight.count("hover") == 1 and flight.manager.status["goal_W"] is not None
    flight.is_flying = False
    flight.fly(0.3)
    flight.lost.clear()
    assert_dropped(flight, "landed")


def test_a_command_of_another_node_to_the_tracker_drops_the_goal():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.flown = None
    flight.fly(0.3)
    assert flight.count("hover") == 0
    assert_dropped(flight, "somebody else commands")


def test_a_tracker_that_refuses_goals_long_after_a_hover_counts_as_commanded_by_another_node():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.lost.add("map")
    flight.fly(2.0)
    flight.lost.clear()
    flight.callbacks_from = flight.now + 30.0
    flight.fly(12.0)
    flight.callbacks_from = flight.now
    assert_dropped(flight, "somebody else let the vehicle hover")


def test_a_bumper_that_repels_the_vehicle_is_let_do_so_and_the_goal_is_dropped():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    back = np.linspace(flight.position, flight.position - (1.0, 0.0, 0.0), 11)
    flight.flown, flight.is_flying, flight.is_repelling = (back, 0.2, flight.now), False, True
    flight.fly(3.0)
    assert flight.count("hover") == 0
    flight.is_repelling = False
    assert_dropped(flight, "the bumper of the control manager repels the vehicle")


def test_a_goal_set_on_the_ground_waits_for_the_take_off():
    flight = FakeFlight(world(), ORIGIN, START)
    flight.look()
    flight.is_flying = False
    flight.tell()
    assert flight.manager.set_goal((10.0, 0.0, 0.0), None, flight.now) == ""
    flight.fly(2.0)
    assert flight.manager.status["reason"] == "waiting: not flying"
    flight.is_flying, flight.callbacks_from = True, flight.now + 2.0
    flight.fly(1.0)
    assert "does not accept goals" in flight.manager.status["reason"]
    assert flight.fly(30.0, reached), flight.manager.status


def test_a_map_in_another_frame_than_the_vehicle_leads_to_hover_with_a_reason():
    flight = started(world(), (25.0, 0.0, 0.0))
    assert flight.fly(10.0, lambda f: f.position[0] > 3.0)
    flight.frames = ("odom", "other_odom")
    flight.fly(0.3)
    status = flight.manager.status
    assert status["reason"] == "hover: the local map is in frame odom, the vehicle in other_odom"
    assert flight.count("hover") == 1 and status["goal_W"] is not None
    flight.frames = ("other_odom", "other_odom")
    assert flight.fly(60.0, reached), flight.manager.status


def test_bad_configuration_is_refused():
    with pytest.raises(voxnav.ConfigError):
        voxnav.PlanningManagerConfig(corridor_radius_m=0.4)
    with pytest.raises(voxnav.ConfigError):
        voxnav.PlanningManagerConfig(no_such_field=1.0)
