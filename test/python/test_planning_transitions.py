# SPDX-License-Identifier: BSD-3-Clause
"""Every row of the table of transitions in voxnav.planning_manager holds, function by function."""

import re
from dataclasses import replace

import numpy as np
import pytest

import voxnav
import voxnav.planning_manager as package
from voxnav.planning_manager import Because, Generate, Hover, Idle, Level, Moving, Plan, Planning, Publish, Reason
from voxnav.planning_manager import flying, planning, stopping
from voxnav.planning_manager.facts import Facts
from voxnav.planning_manager.inputs import Control, Frames, Inputs, Prediction, Timed, Vehicle
from voxnav.planning_manager.states import (Flight, Generating, Goal, Leads, OwnHover, Advance, Publishing,
                                            Searching)

NOW, JOB = 100.0, 7
CONFIG = voxnav.PlanningManagerConfig()
LIMITS = (4.0, 2.0, 2.0, 1.0, 2.0, 1.0)
BECAUSE = Because(Reason.MOVING, "for the test")
GOAL = Goal(np.array([20.0, 0.0, 2.0]), None, has_been_free=True)
TRAJECTORY = voxnav.Trajectory(np.array([(0.4 * i, 0.0, 2.0) for i in range(40)]), 0.2)
FREE = Control(is_flying=True, accepts_goals=True, is_tracking=True)


def inputs(now=NOW, position=(1.0, 0.0, 2.0), velocity=(2.0, 0.0, 0.0), control=FREE):
    times = now + 0.1 * np.arange(60)
    line = np.array(position) + np.outer(times - now, velocity)
    return Inputs(vehicle=Timed(now, Vehicle(np.array(position), np.array(velocity))),
                  prediction=Timed(now, Prediction(times, line)), control=Timed(now, control),
                  limits=Timed(now, LIMITS), T_W_O=Timed(now, np.eye(4)), map_stamp_s=now,
                  frames=Frames("odom", "odom"))


def facts(now=NOW, **kwargs):
    return Facts(now, inputs(now, **kwargs), CONFIG, JOB)


def at_rest(now=NOW, **kwargs):
    return facts(now, velocity=(0.0, 0.0, 0.0), **kwargs)


def flight(begin_s=NOW - 0.5, is_to_goal=False, left_m=10.0, is_tracked=True):
    return Flight(TRAJECTORY, begin_s, Leads(0.7, is_to_goal, left_m), GOAL.position_W, begin_s - 0.1, is_tracked)


def planning_state(**kwargs):
    return Planning(BECAUSE, GOAL, NOW, **kwargs)


def moving_state(**kwargs):
    return Moving(BECAUSE, GOAL, kwargs.pop("flight", flight()), NOW + 1.0, **kwargs)


def view(occupied=None):
    """Returns a view in which all is free around the trajectory, except for a column of voxels at (x, y)."""
    truth = np.ones((60, 20, 12), dtype=np.int8)
    if occupied is not None:
        truth[tuple(np.floor((np.array(occupied) + (4.0, 4.0)) / 0.4).astype(int))] = 2
    nav = voxnav.NavigationMap(voxnav.NavigationMapConfig(min_altitude_m=-5.0))
    grid = voxnav.StateGrid.from_array(truth, (-4.0, -4.0, 0.0), 0.4)
    assert nav.apply_local(1, 0.4, **grid.snapshot()) == voxnav.Applied.APPLIED
    nav.set_vehicle((0.0, 0.0, 2.0))
    nav.set_T_W_O(np.eye(4))
    return nav.view()


def outcome(goal=(12.0, 0.0, 2.0), occupied=None):
    planner = voxnav.PathPlanner(voxnav.PathPlannerConfig())
    field = voxnav.ClearanceField(voxnav.ClearanceFieldConfig(safety_distance_m=0.9))
    field.update(view(occupied))
    return voxnav.run_plan_job(planner, field, CONFIG, view(occupied), (0.0, 0.0, 2.0), goal, LIMITS)


def generating(**kwargs):
    return Generating(JOB, NOW - 0.1, outcome(**kwargs))


def publishing(is_shortening=False):
    return Publishing(JOB, NOW - 0.1, TRAJECTORY, Leads(0.7, True, 0.0), BECAUSE, is_shortening)


def kinds(actions):
    return [type(action) for action in actions]


ANY = [Idle(BECAUSE), Idle(BECAUSE, GOAL), planning_state(), planning_state(job=Searching(JOB, NOW, None)),
       moving_state()]


@pytest.mark.parametrize("state", ANY)
def test_a_goal_leads_to_planning(state):
    new = Goal(np.array([1.0, 2.0, 3.0]), 0.5)
    after, actions = stopping.accept_goal(state, new, facts())
    assert isinstance(after, Planning) and after.goal is new and after.job is None and not actions
    assert after.because.reason is Reason.NEW_GOAL and after.progress is None


def test_a_goal_in_flight_keeps_the_flight_that_no_longer_leads_to_it():
    after, _ = stopping.accept_goal(moving_state(flight=flight(is_to_goal=True)), GOAL, facts())
    assert after.flight.trajectory is TRAJECTORY
    assert not after.flight.leads.is_to_goal and after.flight.leads.left_m is None


def test_a_goal_keeps_a_trajectory_that_is_on_its_way_to_the_tracker():
    after, _ = stopping.accept_goal(planning_state(job=publishing()), GOAL, facts())
    after, actions = flying.publish_done(after, JOB, "", facts())
    assert isinstance(after, Moving) and not actions
    assert not after.flight.leads.is_to_goal


def test_stop_drops_the_goal_and_hovers():
    after, actions = stopping.stop(Because(Reason.STOPPED, "stopped"), facts())
    assert isinstance(after, Idle) and after.goal is None and kinds(actions) == [Hover]


@pytest.mark.parametrize("control, words", [
    (Control(True, False, False), "hover or land"), (Control(False, False, False), "landed"),
    (Control(True, True, False), "somebody else commands")])
def test_a_command_of_another_node_drops_the_goal_and_no_command_follows(control, words):
    after, actions = planning.tick(moving_state(), facts(control=control))
    assert isinstance(after, Idle) and after.goal is None and not actions
    assert after.because.reason is Reason.TAKEN_OVER and words in after.because.sentence


def test_a_trajectory_that_has_ended_is_no_command_of_another_node():
    over = flight(begin_s=NOW - 0.2 - TRAJECTORY.duration_s)
    after, _ = planning.tick(moving_state(flight=over), at_rest(control=Control(True, True, False)))
    assert after.goal is not None


def test_own_hover_explains_the_callbacks_until_they_are_back():
    braking = Control(is_flying=True, accepts_goals=False, is_tracking=False)
    state = planning_state(hover=OwnHover(BECAUSE, NOW - 1.0, NOW - 0.9))
    after, actions = planning.tick(state, facts(control=braking))
    assert after.hover is not None and after.because is BECAUSE and not actions
    after, _ = planning.tick(after, facts())
    assert after.hover is None
    after, _ = planning.tick(after, facts(control=braking))
    assert after.because.reason is Reason.TAKEN_OVER


def test_a_hover_is_repeated_until_it_is_accepted_and_nothing_else_is_done():
    state = planning_state(hover=OwnHover(BECAUSE, NOW))
    after, actions = planning.tick(state, facts(NOW + 0.5))
    assert after.hover.sent_s == NOW and not actions
    after, actions = planning.tick(state, facts(NOW + 1.5))
    assert after.hover.sent_s == NOW + 1.5 and actions[0].is_repeat
    after, _ = stopping.hover_answered(after, "refused", facts(NOW + 1.6))
    assert after.hover.sent_s == NOW + 1.6 and "hover fails: refused" in after.because.sentence
    after, _ = stopping.hover_answered(after, "", facts(NOW + 1.7))
    assert after.hover.accepted_s == NOW + 1.7


def test_no_hover_is_commanded_on_the_ground():
    state = Idle(BECAUSE, None, OwnHover(BECAUSE, NOW - 5.0))
    after, actions = planning.tick(state, at_rest(control=Control(False, False, False)))
    assert after.hover is None and not actions


MISSING = {
    Reason.NO_ODOMETRY: dict(vehicle=None), Reason.NO_DIAGNOSTICS: dict(control=Timed(NOW - 10.0, FREE)),
    Reason.NO_CONSTRAINTS: dict(limits=Timed(NOW, (0.0,) * 6)), Reason.NO_PREDICTION: dict(prediction=None),
    Reason.NO_MAP: dict(map_stamp_s=NOW - 5.0), Reason.FRAMES_DIFFER: dict(frames=Frames("a", "b")),
    Reason.NO_CORRECTION: dict(T_W_O=None), Reason.NODE_LOST: dict(lost_nodes=frozenset(["local_mapper"]))}


@pytest.mark.parametrize("reason", MISSING, ids=lambda reason: reason.name)
def test_a_missing_input_leads_to_idle_with_the_goal_and_hovers_only_in_motion(reason):
    lacking = replace(facts(), inputs=replace(inputs(), **MISSING[reason]))
    for state in (moving_state(), planning_state(job=publishing())):
        after, actions = planning.tick(state, lacking)
        assert isinstance(after, Idle) and after.goal.position_W is GOAL.position_W and kinds(actions) == [Hover]
        assert after.because.reason is reason and after.because.sentence.startswith("hover: ")
        assert reason.level is Level.WARN
    after, actions = planning.tick(planning_state(), lacking)
    assert isinstance(after, Idle) and not actions and after.because.reason is reason


def test_a_clock_that_jumps_back_leads_to_hover_and_restarts_the_timeouts():
    after, actions = stopping.jump_clock(moving_state(), facts(NOW - 50.0))
    assert isinstance(after, Idle) and after.goal is not None and kinds(actions) == [Hover]
    after, actions = stopping.jump_clock(Idle(BECAUSE, None, OwnHover(BECAUSE, NOW)), facts(NOW - 50.0))
    assert after.hover.sent_s == NOW - 50.0


def test_idle_with_a_goal_resumes_once_nothing_is_missing():
    after, actions = planning.tick(Idle(BECAUSE, GOAL), at_rest())
    assert isinstance(after, Planning) and after.because.reason is Reason.RESUMED and kinds(actions) == [Plan]
    after, actions = planning.tick(Idle(BECAUSE), at_rest())
    assert isinstance(after, Idle) and not actions


def test_a_jump_of_the_frame_brakes_in_motion_and_drops_the_job_at_rest():
    because = Because(Reason.FRAME_JUMPED, "jumped")
    after, actions = stopping.jump_frame(moving_state(), because, facts())
    assert isinstance(after, Planning) and after.flight is None and kinds(actions) == [Hover]
    assert after.plan_from_s == NOW + CONFIG.retry_interval_s
    after, actions = stopping.jump_frame(planning_state(job=Searching(JOB, NOW, None)), because, at_rest())
    assert after.job is None and not actions
    idle = Idle(BECAUSE, GOAL)
    assert stopping.jump_frame(idle, because, facts()) == (idle, ())


def test_arrival_needs_the_place_and_rest():
    there = dict(position=(19.5, 0.0, 2.0), control=Control(True, True, False))
    over = moving_state(flight=flight(begin_s=NOW - 30.0))
    after, actions = planning.tick(over, at_rest(**there))
    assert isinstance(after, Idle) and after.goal is None and after.because.reason is Reason.REACHED and not actions
    after, _ = planning.tick(over, facts(**there))
    assert after.goal is not None
    after, _ = planning.tick(over, at_rest(position=(15.0, 0.0, 2.0), control=Control(True, True, False)))
    assert after.goal is not None


@pytest.mark.parametrize("job, words", [
    (Searching(JOB, NOW - 5.0, None), "search"), (replace(publishing(), begin_s=NOW - 5.0), "trajectory service"),
    (Generating(JOB, NOW - 5.0, None), "trajectory generator")])
def test_a_job_that_does_not_answer_has_failed(job, words):
    after, actions = planning.tick(moving_state(job=job), facts())
    assert isinstance(after, Moving) and after.job is None and not actions
    assert after.because == Because(Reason.NO_ANSWER, words + " does not answer")
    after, _ = planning.tick(planning_state(job=job), at_rest())
    assert isinstance(after, Planning) and after.plan_from_s == NOW + CONFIG.retry_interval_s


def test_no_progress_gives_the_goal_up():
    old = Advance(np.array([1.0, 0.0, 2.0]), NOW - CONFIG.stuck_time_s - 1.0)
    after, actions = planning.tick(planning_state(progress=old), at_rest())
    assert isinstance(after, Idle) and after.because.reason is Reason.STUCK and kinds(actions) == [Hover]
    assert after.because.sentence == "stuck: for the test"
    after, _ = planning.tick(planning_state(progress=old), at_rest(position=(3.0, 0.0, 2.0)))
    assert after.progress.since_s == NOW


def test_a_plan_begins_where_the_vehicle_rests_or_where_it_will_be():
    after, (plan,) = planning.tick(planning_state(), at_rest())
    assert np.array_equal(plan.start_O, (1.0, 0.0, 2.0)) and after.job.start_stamp_s is None
    due = replace(moving_state(), plan_from_s=NOW)
    after, (plan,) = planning.tick(due, facts())
    stamp_s = NOW + CONFIG.planning_budget_s + CONFIG.generation_budget_s
    assert isinstance(after, Moving) and after.job == Searching(JOB, NOW, stamp_s)
    assert np.allclose(plan.start_O, (1.0 + 2.0 * (stamp_s - NOW), 0.0, 2.0))
    over = replace(moving_state(flight=flight(begin_s=NOW - 30.0)), plan_from_s=NOW)
    after, actions = planning.tick(over, at_rest(control=Control(True, True, False)))
    assert isinstance(after, Planning) and kinds(actions) == [Plan]


def test_a_plan_needs_a_prediction_that_is_long_enough():
    short = facts()
    near = Timed(NOW, Prediction(np.array([NOW, NOW + 0.5]), np.zeros((2, 3))))
    short = replace(short, inputs=replace(short.inputs, prediction=near))
    after, actions = planning.start_plan(moving_state(), short)
    assert not actions and after.because == Because(Reason.PLAN_FAILED, "tracker prediction is too short")


def test_no_plan_is_due_while_there_is_a_job_or_a_trajectory_to_the_goal():
    later = facts(NOW + 1.5)
    assert planning.is_plan_due(moving_state(), later)
    assert not planning.is_plan_due(moving_state(), facts())
    assert not planning.is_plan_due(moving_state(job=Searching(JOB, NOW, None)), later)
    to_goal = moving_state(flight=flight(is_to_goal=True))
    assert not planning.is_plan_due(to_goal, later)
    moved = np.eye(4)
    moved[0, 3] = 1.0  # the graph has corrected the map, so that the goal is elsewhere in O
    assert planning.is_plan_due(to_goal, replace(later, inputs=replace(later.inputs, T_W_O=Timed(NOW, moved))))


def searching(state_class=planning_state, **kwargs):
    return state_class(job=Searching(JOB, NOW - 0.1, None), **kwargs)


def test_a_way_that_is_worth_flying_goes_to_the_generator():
    after, (generate,) = planning.plan_done(searching(), JOB, outcome(), at_rest())
    assert isinstance(generate, Generate) and isinstance(after.job, Generating)
    assert np.allclose(generate.waypoints_O[-1], (12.0, 0.0, 2.0)) and generate.heading_rad is None


def test_the_heading_at_the_goal_is_turned_into_the_odometry_frame():
    turned = np.eye(4)
    turned[:2, :2] = [[0.0, -1.0], [1.0, 0.0]]
    known = at_rest()
    known = replace(known, inputs=replace(known.inputs, T_W_O=Timed(NOW, turned)))
    state = replace(searching(), goal=replace(GOAL, heading_rad=2.0))
    _, (generate,) = planning.plan_done(state, JOB, outcome(), known)
    assert generate.heading_rad == pytest.approx(2.0 - np.pi / 2)


def test_a_way_that_leads_no_nearer_is_not_flown():
    wall = outcome(goal=(30.0, 0.0, 2.0))
    assert not wall.is_to_goal and len(wall.waypoints_O)
    good = searching(moving_state, flight=flight(left_m=wall.left_m))
    after, actions = planning.plan_done(good, JOB, wall, facts())
    assert isinstance(after, Moving) and not actions
    assert after.plan_from_s == NOW + CONFIG.replan_interval_s
    poor = searching(moving_state, flight=flight(left_m=wall.left_m + 5.0))
    assert kinds(planning.plan_done(poor, JOB, wall, facts())[1]) == [Generate]


def blocked(status, path=((0.0, 0.0, 2.0),)):
    class Plan:
        pass
    result = Plan()
    result.path = np.array(path).reshape(-1, 3)

    class Outcome:
        waypoints_O, problem, plan = np.zeros((0, 3)), "no way", result
    Outcome.status = status
    return Outcome()


def test_a_search_without_a_way_is_tried_again():
    after, actions = planning.plan_done(searching(), JOB, blocked(voxnav.PlanStatus.NO_PATH), at_rest())
    assert isinstance(after, Planning) and not actions and after.because == Because(Reason.PLAN_FAILED, "no way")
    after, _ = planning.plan_done(searching(moving_state), JOB, blocked(voxnav.PlanStatus.NO_PATH), facts())
    assert isinstance(after, Moving) and after.plan_from_s == NOW + CONFIG.retry_interval_s


def test_beside_a_blocked_goal_the_goal_is_given_up():
    found = blocked(voxnav.PlanStatus.GOAL_BLOCKED)
    after, actions = planning.plan_done(searching(), JOB, found, at_rest())
    assert isinstance(after, Idle) and after.because.reason is Reason.UNREACHABLE and kinds(actions) == [Hover]
    for other in (blocked(voxnav.PlanStatus.GOAL_BLOCKED, ((0, 0, 2), (9, 0, 2))),
                  blocked(voxnav.PlanStatus.GOAL_BLOCKED, ())):
        assert isinstance(planning.plan_done(searching(), JOB, other, at_rest())[0], Planning)


def test_a_safe_trajectory_is_published():
    after, (publish,) = flying.generate_done(planning_state(job=generating()), JOB, TRAJECTORY, "", view(), at_rest())
    assert isinstance(publish, Publish) and not publish.is_shortening
    assert after.job.leads.is_to_goal and after.job.because.sentence == "moving to the goal"


def test_only_the_safe_part_of_a_generated_trajectory_is_published():
    state = planning_state(job=generating())
    after, (publish,) = flying.generate_done(state, JOB, TRAJECTORY, "", view((11.0, 0.0)), at_rest())
    assert publish.trajectory.length_m < 11.0 and not after.job.leads.is_to_goal
    assert after.job.leads.left_m == pytest.approx(TRAJECTORY.length_m - publish.trajectory.length_m, abs=0.1)


@pytest.mark.parametrize("trajectory, problem, seen, words", [
    (None, "refused", view(), "trajectory generator: refused"), (None, "", view(), "empty trajectory"),
    (TRAJECTORY, "", None, "no map"), (TRAJECTORY, "", view((1.0, 0.0)), "not known free: occupied")])
def test_without_a_safe_trajectory_planning_is_tried_again(trajectory, problem, seen, words):
    state = planning_state(job=generating())
    after, actions = flying.generate_done(state, JOB, trajectory, problem, seen, at_rest())
    assert isinstance(after, Planning) and after.job is None and not actions
    assert after.because.reason is Reason.GENERATOR_FAILED and words in after.because.sentence


def test_the_tracker_takes_or_refuses_a_trajectory():
    after, _ = flying.publish_done(planning_state(job=publishing()), JOB, "", facts())
    assert isinstance(after, Moving) and after.flight.begin_s == NOW and after.flight.asked_s == NOW - 0.1
    assert after.because is BECAUSE and after.plan_from_s == NOW + CONFIG.replan_interval_s
    after, actions = flying.publish_done(planning_state(job=publishing()), JOB, "busy", at_rest())
    assert isinstance(after, Planning) and not actions and after.because.reason is Reason.TRAJECTORY_REFUSED
    after, _ = flying.publish_done(moving_state(job=publishing()), JOB, "busy", facts())
    assert isinstance(after, Moving) and after.flight.trajectory is TRAJECTORY


def test_the_tracker_takes_or_refuses_a_shortened_trajectory():
    state = planning_state(flight=flight(), job=publishing(is_shortening=True))
    after, _ = flying.publish_done(state, JOB, "", facts())
    assert isinstance(after, Planning) and after.flight.begin_s == NOW and after.plan_from_s == NOW
    after, actions = flying.publish_done(state, JOB, "busy", facts())
    assert isinstance(after, Planning) and after.flight is None and kinds(actions) == [Hover]
    assert after.because.reason is Reason.BRAKE


def test_a_trajectory_that_is_taken_too_late_is_stopped():
    after, actions = flying.publish_done(planning_state(), JOB, "", facts())
    assert isinstance(after, Planning) and kinds(actions) == [Hover]
    for state in (Idle(BECAUSE), planning_state(hover=OwnHover(BECAUSE, NOW)),
                  planning_state(job=replace(publishing(), job=JOB + 1))):
        assert flying.publish_done(state, JOB, "", facts()) == (state, ())
    assert flying.publish_done(planning_state(), JOB, "busy", facts())[1] == ()


def test_a_safe_corridor_changes_nothing():
    state = moving_state()
    assert flying.check(state, view(), facts()) == (state, ())


def test_an_unsafe_corridor_shortens_the_flight():
    after, (publish,) = flying.check(moving_state(), view((8.0, 0.0)), facts())
    assert isinstance(after, Planning) and after.because.reason is Reason.SHORTENED
    assert publish.is_shortening and after.job.is_shortening and after.flight.trajectory is TRAJECTORY
    again, actions = flying.check(after, view((8.0, 0.0)), facts(NOW + 0.2))
    assert again is after and not actions, "the shortened trajectory is on its way"
    late, actions = flying.check(after, view((8.0, 0.0)), facts(NOW + 0.5))
    assert kinds(actions) == [Hover] and late.because.reason is Reason.BRAKE


@pytest.mark.parametrize("seen", [None, view((2.4, 0.0))])
def test_without_room_to_stop_or_without_a_map_the_vehicle_brakes(seen):
    progress = Advance(np.zeros(3), NOW - 1.0)
    after, actions = flying.check(moving_state(progress=progress), seen, facts())
    assert isinstance(after, Planning) and after.flight is None and kinds(actions) == [Hover]
    assert after.because.reason is Reason.BRAKE and after.progress is progress


@pytest.mark.parametrize("state", ANY)
def test_answers_to_jobs_that_no_longer_matter_are_ignored(state):
    assert planning.plan_done(state, JOB + 1, outcome(), facts()) == (state, ())
    assert flying.generate_done(state, JOB + 1, TRAJECTORY, "", view(), facts()) == (state, ())
    assert flying.publish_done(state, JOB + 1, "refused", facts()) == (state, ())


def test_the_table_names_functions_that_exist():
    rows = [line for line in package.__doc__.splitlines() if re.match(r"(any|Idle|P, M|Planning|Moving)  ", line)]
    assert len(rows) > 20
    for row in rows:
        name = row.split()[-1]
        assert any(hasattr(module, name) for module in (stopping, planning, flying)) or row.endswith("   "), row
