# SPDX-License-Identifier: BSD-3-Clause
"""Every row of the table of transitions in voxnav.planning_manager holds, function by function."""

import re
from dataclasses import replace

import numpy as np
import pytest

import voxnav
import voxnav.planning_manager as package
from voxnav.planning_manager import (Because, Generate, Generated, Hover, Idle, Level, Means, Moving, Plan, Planning,
                                     Publish, Reason)
from voxnav.planning_manager import checking, flying, main_loop, planning, stopping, stops, takeover, ways
from voxnav.planning_manager.facts import Facts
from voxnav.planning_manager.inputs import Control, Frames, Inputs, Prediction, Timed, Vehicle
from voxnav.planning_manager.progress import DEAD_END_M, GoalProgress
from voxnav.planning_manager.states import Flight, Generating, Goal, Leads, OwnHover, Publishing, Searching
from voxnav.planning_manager.verdicts import MEANINGS, Verdict

NOW, JOB = 100.0, 7
CONFIG = voxnav.PlanningManagerConfig()
LIMITS = (4.0, 2.0, 2.0, 1.0, 2.0, 1.0)
BECAUSE = Because(Reason.MOVING, "for the test")
GOAL = Goal(np.array([20.0, 0.0, 2.0]), None, has_been_free=True)
TRAJECTORY = voxnav.Trajectory(np.array([(0.4 * i, 0.0, 2.0) for i in range(31)]), 0.2)
GENERATED = Generated(TRAJECTORY, None)
FREE = Control(is_flying=True, accepts_goals=True, is_tracking=True)


def inputs(now=NOW, position=(1.0, 0.0, 2.0), velocity=(2.0, 0.0, 0.0), control=FREE):
    times = now + 0.1 * np.arange(60)
    line = np.array(position) + np.outer(times - now, velocity)
    return Inputs(vehicle=Timed(now, Vehicle(np.array(position), np.array(velocity))),
                  prediction=Timed(now, Prediction(times, line)), control=Timed(now, control),
                  limits=Timed(now, LIMITS), T_W_O=Timed(now, np.eye(4)), map_stamp_s=now,
                  frames=Frames("odom", "odom"))


def facts(now=NOW, seen=None, **kwargs):
    """seen: the map; None if there is none."""
    return Facts(now, inputs(now, **kwargs), CONFIG, JOB, lambda: seen)


def at_rest(now=NOW, **kwargs):
    return facts(now, velocity=(0.0, 0.0, 0.0), **kwargs)


def flight(begin_s=NOW - 0.5, is_to_goal=False, left_m=10.0, is_tracked=True):
    leads = Leads(0.7, is_to_goal, left_m, is_to_goal)
    return Flight(TRAJECTORY, begin_s, leads, GOAL.position_W, begin_s - 0.1, begin_s, is_tracked)


def planning_state(**kwargs):
    return Planning(BECAUSE, GOAL, NOW, **kwargs)


def moving_state(**kwargs):
    return Moving(BECAUSE, GOAL, kwargs.pop("flight", flight()), NOW + 1.0, **kwargs)


def view(occupied=None, height_m=4.8, state=2):
    """Returns a view in which all is free around the trajectory, except for a column of voxels at (x, y)."""
    truth = np.ones((60, 20, 18), dtype=np.int8)
    if occupied is not None:
        column = tuple(np.floor((np.array(occupied) + (4.0, 4.0)) / 0.4).astype(int))
        truth[column][:int(np.ceil(height_m / 0.4))] = state
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
    return Publishing(JOB, NOW - 0.1, TRAJECTORY, None, Leads(0.7, True, 0.0), BECAUSE, is_shortening)


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
    after, actions = stopping.stop(moving_state(), Because(Reason.STOPPED, "stopped"), facts())
    assert isinstance(after, Idle) and after.goal is None and kinds(actions) == [Hover]


@pytest.mark.parametrize("control, words", [
    (Control(True, False, False), "let the vehicle hover"), (Control(False, False, False), "landed"),
    (Control(True, True, False), "somebody else commands")])
def test_a_command_of_another_node_drops_the_goal_and_no_command_follows(control, words):
    after, actions = main_loop.tick(moving_state(), facts(control=control))
    assert isinstance(after, Idle) and after.goal is None and not actions
    assert after.because.reason is Reason.TAKEN_OVER and words in after.because.sentence


def test_a_trajectory_that_has_ended_is_no_command_of_another_node():
    over = flight(begin_s=NOW - 0.2 - TRAJECTORY.duration_s)
    after, _ = main_loop.tick(moving_state(flight=over), at_rest(control=Control(True, True, False)))
    assert after.goal is not None


def test_own_hover_explains_the_callbacks_until_they_are_back():
    braking = Control(is_flying=True, accepts_goals=False, is_tracking=False)
    state = planning_state(hover=OwnHover(BECAUSE, NOW - 1.0, NOW - 0.9))
    after, actions = main_loop.tick(state, facts(control=braking))
    assert after.hover is not None and after.because is BECAUSE and not actions
    after, _ = main_loop.tick(after, facts())
    assert after.hover is None
    after, _ = main_loop.tick(after, facts(control=braking))
    assert after.because.reason is Reason.TAKEN_OVER


def test_a_hover_is_repeated_until_it_is_accepted_and_nothing_else_is_done():
    state = planning_state(hover=OwnHover(BECAUSE, NOW))
    after, actions = main_loop.tick(state, facts(NOW + 0.5))
    assert after.hover.sent_s == NOW and not actions
    after, actions = main_loop.tick(state, facts(NOW + 1.5))
    assert after.hover.sent_s == NOW + 1.5 and actions[0].is_repeat
    after, _ = stopping.hover_answered(after, "refused", facts(NOW + 1.6))
    assert after.hover.sent_s == NOW + 1.6 and "hover fails: refused" in after.because.sentence
    after, _ = stopping.hover_answered(after, "", facts(NOW + 1.7))
    assert after.hover.accepted_s == NOW + 1.7


def test_no_hover_is_commanded_on_the_ground():
    state = Idle(BECAUSE, None, OwnHover(BECAUSE, NOW - 5.0))
    after, actions = main_loop.tick(state, at_rest(control=Control(False, False, False)))
    assert after.hover is None and not actions


MISSING = {
    Reason.NO_ODOMETRY: dict(vehicle=None), Reason.NO_DIAGNOSTICS: dict(control=Timed(NOW - 10.0, FREE)),
    Reason.NO_CONSTRAINTS: dict(limits_problem="constraints are not finite"),
    Reason.NO_PREDICTION: dict(prediction=None),
    Reason.NO_MAP: dict(map_stamp_s=NOW - 5.0), Reason.FRAMES_DIFFER: dict(frames=Frames("a", "b", "b")),
    Reason.NO_CORRECTION: dict(T_W_O=None), Reason.NODE_LOST: dict(lost_nodes=frozenset(["local_mapper"]))}


@pytest.mark.parametrize("reason", MISSING, ids=lambda reason: reason.name)
def test_a_missing_input_leads_to_idle_with_the_goal_and_hovers_only_in_motion(reason):
    lacking = replace(facts(), inputs=replace(inputs(), **MISSING[reason]))
    for state in (moving_state(), planning_state(job=publishing())):
        after, actions = main_loop.tick(state, lacking)
        assert isinstance(after, Idle) and after.goal.position_W is GOAL.position_W and kinds(actions) == [Hover]
        assert after.because.reason is reason and after.because.sentence.startswith("hover: ")
        assert reason.level is Level.WARN
    after, actions = main_loop.tick(planning_state(), lacking)
    assert isinstance(after, Idle) and not actions and after.because.reason is reason


@pytest.mark.parametrize("frames, words", [
    (Frames("a", "b", "a"), "the local map is in frame a, the vehicle in b"),
    (Frames("b", "b", "a"), "the map correction is of frame a, the vehicle in b"), (Frames("b", "b", "b"), "")])
def test_frames_that_differ_are_named(frames, words):
    after, _ = main_loop.tick(moving_state(), replace(facts(), inputs=replace(inputs(), frames=frames)))
    assert after.because.sentence == ("hover: " + words if words else BECAUSE.sentence)


def test_a_clock_that_jumps_back_leads_to_hover_and_restarts_the_timeouts():
    after, actions = stopping.jump_clock(moving_state(), facts(NOW - 50.0))
    assert isinstance(after, Idle) and after.goal is not None and kinds(actions) == [Hover]
    after, actions = stopping.jump_clock(Idle(BECAUSE, None, OwnHover(BECAUSE, NOW)), facts(NOW - 50.0))
    assert after.hover.sent_s == NOW - 50.0


def test_idle_with_a_goal_resumes_once_nothing_is_missing():
    after, actions = main_loop.tick(Idle(BECAUSE, GOAL), at_rest())
    assert isinstance(after, Planning) and after.because.reason is Reason.RESUMED and kinds(actions) == [Plan]
    after, actions = main_loop.tick(Idle(BECAUSE), at_rest())
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


def test_a_goal_is_dropped_with_the_map_in_which_it_is():
    closed = Because(Reason.MAP_CLOSED, "closed")
    after, actions = stopping.close_map(moving_state(), closed, facts(seen=view()))
    assert after.goal is None and after.because is closed and kinds(actions) == [Hover]
    assert actions[0].means is Means.HOVER, "no other way to rest can be checked on a map of another origin"
    resting = planning_state(hover=OwnHover(BECAUSE, NOW, NOW))
    after, actions = stopping.close_map(resting, closed, at_rest(seen=view()))
    assert after.goal is None and after.because is closed and after.hover is resting.hover and not actions
    idle = Idle(BECAUSE)
    assert stopping.close_map(idle, closed, facts()) == (idle, ())


def test_nothing_is_checked_on_a_map_of_another_origin():
    manager = voxnav.PlanningManager(CONFIG, (-5.0, 20.0), lambda: view())
    for frames, is_seen in ((("a", "a"), True), (("a", "b"), False), (("", "b"), True), (("a", "a", "a"), True),
                            (("b", "b", "a"), False)):
        manager.set_frames(*frames)
        assert (manager._facts(NOW).look() is not None) == is_seen


def test_arrival_needs_the_place_and_rest():
    there = dict(position=(19.5, 0.0, 2.0), control=Control(True, True, False))
    over = moving_state(flight=flight(begin_s=NOW - 30.0))
    after, actions = main_loop.tick(over, at_rest(**there))
    assert isinstance(after, Idle) and after.goal is None and after.because.reason is Reason.REACHED and not actions
    after, _ = main_loop.tick(over, facts(**there))
    assert after.goal is not None
    after, _ = main_loop.tick(over, at_rest(position=(15.0, 0.0, 2.0), control=Control(True, True, False)))
    assert after.goal is not None


@pytest.mark.parametrize("job, words", [
    (Searching(JOB, NOW - 5.0, None), "search"), (replace(publishing(), begin_s=NOW - 5.0), "trajectory service"),
    (Generating(JOB, NOW - 5.0, None), "trajectory generator")])
def test_a_job_that_does_not_answer_has_failed(job, words):
    after, actions = main_loop.tick(moving_state(job=job), facts())
    assert isinstance(after, Moving) and after.job is None and not actions
    assert after.because == Because(Reason.NO_ANSWER, words + " does not answer")
    after, _ = main_loop.tick(planning_state(job=job), at_rest())
    assert isinstance(after, Planning) and after.plan_from_s == NOW + CONFIG.retry_interval_s


def test_no_progress_gives_the_goal_up_with_the_last_verdict():
    old = GoalProgress(NOW - CONFIG.stuck_time_s - 1.0, 20.0)
    after, actions = main_loop.tick(planning_state(progress=old), at_rest())
    assert isinstance(after, Idle) and after.because.reason is Reason.STUCK and kinds(actions) == [Hover]
    assert after.because.sentence == "stuck: no shorter way for 25 s: for the test"
    enclosed = Verdict(Because(Reason.GOAL_ENCLOSED, "enclosed"), NOW, 3.0)
    after, _ = main_loop.tick(planning_state(progress=old, verdict=enclosed), at_rest())
    assert after.because is enclosed.because
    closed = GoalProgress(NOW, 20.0, CONFIG.max_dead_ends)
    after, _ = main_loop.tick(planning_state(progress=closed), at_rest())
    assert after.because.sentence == "stuck: 20 ways were closed: for the test"


def test_a_shorter_way_left_on_the_flown_trajectory_is_progress_and_motion_alone_is_not():
    # 12 m of trajectory and 10 m beyond it are planned; 2 m of it are flown.
    known = facts(position=(2.0, 0.0, 2.0))
    flown = flight(begin_s=NOW - 1.0)
    after, _ = main_loop.tick(moving_state(flight=flown, progress=GoalProgress(NOW - 9.0, 21.5)), known)
    assert after.progress.since_s == NOW and after.progress.shortest_m == pytest.approx(20.0)
    for shortest_m in (20.5, 12.0):
        old = GoalProgress(NOW - 9.0, shortest_m)
        after, _ = main_loop.tick(moving_state(flight=flown, progress=old), known)
        assert after.progress is old


def test_a_plan_that_is_much_longer_is_a_dead_end_and_begins_anew():
    progress = GoalProgress(NOW).after_plan(30.0, NOW + 1.0)
    assert progress == GoalProgress(NOW + 1.0, 30.0)
    assert progress.after_plan(30.0 + DEAD_END_M, NOW + 2.0) is progress
    detour = progress.after_plan(30.1 + DEAD_END_M, NOW + 2.0)
    assert detour == GoalProgress(NOW + 2.0, 30.1 + DEAD_END_M, 1)
    assert detour.after_plan(25.0, NOW + 3.0) == GoalProgress(NOW + 3.0, 25.0, 1)


def test_a_plan_begins_where_the_vehicle_rests_or_where_it_will_be():
    after, (plan,) = main_loop.tick(planning_state(), at_rest())
    assert np.array_equal(plan.start_O, (1.0, 0.0, 2.0)) and after.job.start_stamp_s is None
    due = replace(moving_state(), plan_from_s=NOW)
    after, (plan,) = main_loop.tick(due, facts())
    stamp_s = NOW + CONFIG.planning_budget_s + CONFIG.generation_budget_s
    assert isinstance(after, Moving) and after.job == Searching(JOB, NOW, stamp_s)
    assert np.allclose(plan.start_O, (1.0 + 2.0 * (stamp_s - NOW), 0.0, 2.0))
    over = replace(moving_state(flight=flight(begin_s=NOW - 30.0)), plan_from_s=NOW)
    after, actions = main_loop.tick(over, at_rest(control=Control(True, True, False)))
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
    news = facts(seen=view())
    assert planning.is_plan_due(to_goal, news) and not planning.is_plan_due(moving_state(job=publishing()), news)
    assert not planning.is_plan_due(replace(to_goal, goal_state=news.goal_state(GOAL)), news)
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


@pytest.mark.parametrize("age_s, wait_s", [(0.0, 1.5), (3.0, 1.0), (3.2, 0.8), (4.5, 0.5)])
def test_the_next_plan_begins_before_the_flight_brakes(age_s, wait_s):
    points = np.zeros((26, 3))
    points[:, 0] = 0.4 * np.arange(26)  # 2 m/s for 5 s; the last step ends at rest
    flown = replace(flight(begin_s=NOW - age_s), trajectory=voxnav.Trajectory(points, 0.2))
    assert flown.trajectory.braking_begins_s == pytest.approx(4.8)
    assert CONFIG.planning_budget_s + CONFIG.generation_budget_s == pytest.approx(0.8)
    assert facts().next_plan_s(flown) == pytest.approx(NOW + wait_s)


def test_a_way_that_leads_no_nearer_is_not_flown():
    wall = outcome(goal=(30.0, 0.0, 2.0))
    assert not wall.is_to_goal and len(wall.waypoints_O)
    good = searching(moving_state, flight=flight(left_m=wall.left_m))
    after, actions = planning.plan_done(good, JOB, wall, facts())
    assert isinstance(after, Moving) and not actions
    assert after.plan_from_s == NOW + CONFIG.replan_interval_s
    poor = searching(moving_state, flight=flight(left_m=wall.left_m + 5.0))
    assert kinds(planning.plan_done(poor, JOB, wall, facts())[1]) == [Generate]


def blocked(status, path=((0.0, 0.0, 2.0),), waypoints=(), remaining_m=5.0):
    class Plan:
        pass
    result = Plan()
    result.path, result.remaining_m = np.array(path, dtype=float).reshape(-1, 3), remaining_m

    class Outcome:
        waypoints_O, problem, plan, is_to_goal = np.array(waypoints).reshape(-1, 3), "no way", result, False
    Outcome.status = status
    return Outcome()


def test_every_status_of_a_search_has_a_meaning():
    assert set(MEANINGS) == set(voxnav.PlanStatus)


def test_a_search_without_a_way_is_tried_again():
    after, actions = planning.plan_done(searching(), JOB, blocked(voxnav.PlanStatus.START_BLOCKED), at_rest())
    assert isinstance(after, Planning) and not actions and after.because == Because(Reason.PLAN_FAILED, "no way")
    assert after.verdict is None
    after, _ = planning.plan_done(searching(moving_state), JOB, blocked(voxnav.PlanStatus.NO_PATH), facts())
    assert isinstance(after, Moving) and after.plan_from_s == NOW + CONFIG.retry_interval_s and after.verdict is None


@pytest.mark.parametrize("status, reason", [
    (voxnav.PlanStatus.NO_PATH, Reason.NO_WAY), (voxnav.PlanStatus.PARTIAL_BLOCKED, Reason.NO_WAY),
    (voxnav.PlanStatus.GOAL_UNKNOWN, Reason.GOAL_UNSEEN)])
def test_a_verdict_that_persists_gives_the_goal_up(status, reason):
    state, actions = planning.plan_done(searching(), JOB, blocked(status), at_rest())
    assert isinstance(state, Planning) and state.because.reason is reason and not actions
    for later_s, is_decided in ((2.9, False), (3.1, True)):
        again = replace(state, job=Searching(JOB, NOW, None))
        after, actions = planning.plan_done(again, JOB, blocked(status), at_rest(NOW + later_s))
        assert isinstance(after, Idle) == is_decided and after.because == state.because
        assert kinds(actions) == ([Hover] if is_decided else [])
    other = replace(state, job=Searching(JOB, NOW, None))
    after, _ = planning.plan_done(other, JOB, blocked(voxnav.PlanStatus.START_BLOCKED), at_rest(NOW + 2.0))
    assert after.verdict is None, "it did not persist"


ABOUT_GOAL = {voxnav.PlanStatus.GOAL_BLOCKED: Reason.GOAL_BLOCKED,
              voxnav.PlanStatus.GOAL_ENCLOSED: Reason.GOAL_ENCLOSED,
              voxnav.PlanStatus.GOAL_BELOW_GROUND: Reason.GOAL_BELOW_GROUND}


@pytest.mark.parametrize("status", ABOUT_GOAL)
def test_a_goal_that_no_place_is_near_is_given_up_in_flight_after_a_second_search(status):
    found = blocked(status, ())
    after, _ = planning.plan_done(searching(moving_state), JOB, found, facts())
    assert isinstance(after, Moving) and after.because.reason is ABOUT_GOAL[status]
    again = replace(after, job=Searching(JOB, NOW, None))
    after, actions = planning.plan_done(again, JOB, found, facts(NOW + 0.5))
    assert isinstance(after, Idle) and after.because.reason is ABOUT_GOAL[status] and kinds(actions) == [Hover]


def test_nothing_is_flown_towards_a_goal_below_the_ground():
    found = blocked(voxnav.PlanStatus.GOAL_BELOW_GROUND, ((0, 0, 2), (9, 0, 2)), ((0, 0, 2), (9, 0, 2)))
    after, actions = planning.plan_done(searching(), JOB, found, at_rest())
    assert isinstance(after, Planning) and after.because.reason is Reason.GOAL_BELOW_GROUND and not actions


@pytest.mark.parametrize("status", [voxnav.PlanStatus.GOAL_BLOCKED, voxnav.PlanStatus.GOAL_ENCLOSED])
def test_at_the_nearest_place_the_goal_is_given_up(status):
    after, actions = planning.plan_done(searching(), JOB, blocked(status), at_rest())
    assert isinstance(after, Idle) and after.because.reason is ABOUT_GOAL[status] and kinds(actions) == [Hover]
    aside = blocked(status, ((0, 0, 2), (2, 0, 2)), ((0, 0, 2), (2, 0, 2)), 18.5)
    after, _ = planning.plan_done(searching(), JOB, aside, at_rest())
    assert isinstance(after, Idle), "another place that is hardly nearer is not worth flying to"
    unsafe = blocked(status, ((0, 0, 2), (9, 0, 2)))
    after, _ = planning.plan_done(searching(), JOB, unsafe, at_rest())
    assert isinstance(after, Planning) and after.because == Because(Reason.PLAN_FAILED, "no way")
    assert not after.verdict.is_final(NOW + 99.0), "there is a way, but it is not known to be free"
    old = replace(after, progress=GoalProgress(NOW - CONFIG.stuck_time_s - 1.0, 5.0))
    after, _ = main_loop.tick(old, at_rest())
    assert isinstance(after, Idle) and after.because.reason is ABOUT_GOAL[status], "the same answer as elsewhere"


def test_a_flight_to_the_nearest_place_of_a_blocked_goal_is_the_last_until_the_map_shows_another():
    found = outcome(goal=(12.0, 0.0, 2.0), occupied=(12.0, 0.0))
    assert found.status == voxnav.PlanStatus.GOAL_BLOCKED and len(found.waypoints_O)
    line = found.waypoints_O
    arcs = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    passed = np.append(np.arange(0.0, arcs[-1], 0.4), arcs[-1])
    points = np.column_stack([np.interp(passed, arcs, line[:, k]) for k in range(3)])
    state = planning_state(job=Generating(JOB, NOW, found))
    known = facts(position=(0.0, 0.0, 2.0), velocity=(0.0, 0.0, 0.0), seen=view((12.0, 0.0)))
    after, (publish,) = flying.generate_done(state, JOB, generated_line(points), known)
    assert after.job.leads.is_last and not after.job.leads.is_to_goal
    assert publish.because.reason is Reason.GOAL_BLOCKED
    flying_, _ = flying.publish_done(after, JOB, "", known)
    planned = replace(flying_, goal_state=known.goal_state(GOAL))
    later = facts(NOW + 2.0, seen=view((12.0, 0.0)))
    assert not planning.is_plan_due(planned, later)
    assert planning.is_plan_due(replace(planned, goal_state=2), later), "the map shows the goal's place by now"


def test_a_safe_trajectory_is_published():
    after, (publish,) = flying.generate_done(planning_state(job=generating()), JOB, GENERATED, at_rest(seen=view()))
    assert isinstance(publish, Publish) and not publish.is_shortening
    assert after.job.leads.is_to_goal and after.job.because.sentence == "moving to the goal"


def test_only_the_safe_part_of_a_generated_trajectory_is_published():
    state = planning_state(job=generating())
    after, (publish,) = flying.generate_done(state, JOB, GENERATED, at_rest(seen=view((11.0, 0.0))))
    assert publish.trajectory.length_m < 11.0 and not after.job.leads.is_to_goal
    assert after.job.leads.left_m == pytest.approx(TRAJECTORY.length_m - publish.trajectory.length_m, abs=0.1)


@pytest.mark.parametrize("generated, seen, words", [
    ("refused", view(), "trajectory generator: refused"), (GENERATED, None, "no map"),
    (GENERATED, view((1.0, 0.0)), "not known free: occupied")])
def test_without_a_safe_trajectory_planning_is_tried_again(generated, seen, words):
    state = planning_state(job=generating())
    after, actions = flying.generate_done(state, JOB, generated, at_rest(seen=seen))
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
    newer = planning_state(job=replace(publishing(), job=JOB + 1))
    assert flying.publish_done(newer, JOB, "", facts()) == (newer, ())
    for state in (Idle(BECAUSE, GOAL, OwnHover(BECAUSE, NOW, NOW)), planning_state(hover=OwnHover(BECAUSE, NOW))):
        after, (hover,) = flying.publish_done(state, JOB, "", facts())
        assert hover.is_repeat and hover.means is Means.HOVER and after.hover.accepted_s is None
    assert flying.publish_done(planning_state(), JOB, "busy", facts())[1] == ()


@pytest.mark.parametrize("control, is_stopped", [(FREE, True), (Control(True, True, False), False),
                                                 (Control(True, False, True), False)])
def test_a_trajectory_taken_after_the_goal_was_dropped_is_stopped_unless_somebody_has_ended_it(control, is_stopped):
    late, actions = flying.publish_done(Idle(BECAUSE), JOB, "", facts())
    assert late.late_s == NOW and not actions
    early, actions = main_loop.tick(late, facts(control=control))
    assert early.late_s == NOW and not actions, "these diagnostics do not show it yet"
    after, actions = main_loop.tick(late, facts(NOW + 0.1, control=control))
    assert after.late_s is None and kinds(actions) == [Hover] * is_stopped
    assert (after.hover is not None) == is_stopped and after.goal is None


def test_a_safe_corridor_changes_nothing():
    state = moving_state()
    assert checking.check(state, facts(seen=view())) == (state, ())


def test_an_unsafe_corridor_shortens_the_flight():
    after, (publish,) = checking.check(moving_state(), facts(seen=view((8.0, 0.0))))
    assert isinstance(after, Planning) and after.because.reason is Reason.SHORTENED
    assert publish.is_shortening and after.job.is_shortening and after.flight.trajectory is TRAJECTORY
    again, actions = checking.check(after, facts(NOW + 0.2, seen=view((8.0, 0.0))))
    assert again is after and not actions, "the shortened trajectory is on its way"
    late, actions = checking.check(after, facts(NOW + 0.5, seen=view((8.0, 0.0))))
    assert kinds(actions) == [Hover] and late.because.reason is Reason.BRAKE


@pytest.mark.parametrize("column_m, is_shortened", [(8.0, True), (6.8, True), (6.0, False)])
def test_level_flight_brakes_by_the_horizontal_limit(column_m, is_shortened):
    # At 3 m/s it takes 0.4 s and 3.2 m at 1.4 m/s^2 to stop, 4.4 m together; the vertical limit would need 7.6 m.
    fast = replace(flight(), trajectory=voxnav.Trajectory(np.array([(0.6 * i, 0.0, 2.0) for i in range(30)]), 0.2))
    known = facts(velocity=(3.0, 0.0, 0.0), seen=view((column_m, 0.0)))
    _, (action,) = checking.check(moving_state(flight=fast), known)
    assert isinstance(action, Publish) == is_shortened
    assert isinstance(action, Hover) != is_shortened


def test_a_search_that_cannot_be_made_is_tried_again():
    state = searching()
    assert planning.plan_failed(state, JOB + 1, "no map", facts()) == (state, ())
    after, actions = planning.plan_failed(state, JOB, "no map", at_rest())
    assert isinstance(after, Planning) and after.job is None and not actions
    assert after.because == Because(Reason.PLAN_FAILED, "no search: no map")


@pytest.mark.parametrize("seen", [None, view((2.4, 0.0))])
def test_without_room_to_stop_or_without_a_map_the_vehicle_brakes(seen):
    progress = GoalProgress(NOW - 1.0, 5.0)
    after, actions = checking.check(moving_state(progress=progress), facts(seen=seen))
    assert isinstance(after, Planning) and after.flight is None and kinds(actions) == [Hover]
    assert after.because.reason is Reason.BRAKE and after.progress is progress


def predicting(line, now=NOW, velocity=(2.0, 0.0, 0.0), **kwargs):
    """Returns facts in which the tracker predicts a line (n, 3), 0.2 s apart, beginning with the vehicle."""
    known = facts(now, position=line[0], velocity=velocity, **kwargs)
    times = now + 0.2 * np.arange(len(line))
    return replace(known, inputs=replace(known.inputs, prediction=Timed(now, Prediction(times, np.array(line)))))


AHEAD = [(1.0 + 0.4 * i, 0.0, 2.0) for i in range(40)]
ASIDE = [(1.0, 0.3 * i, 2.0) for i in range(40)]


def test_a_vehicle_far_from_its_trajectory_gets_a_new_plan_and_brakes_farther_away():
    for offset_m in (0.9, 1.1, 3.6):
        line = np.array(AHEAD) + (0.0, 0.0, offset_m)
        after, actions = checking.check(moving_state(), predicting(line, seen=view()))
        if offset_m < 1.0:
            assert after.because is BECAUSE and not actions
        elif offset_m < 3.5:
            assert after.because.reason is Reason.DEVIATED and after.plan_from_s == NOW and not actions
            assert isinstance(after, Moving) and after.flight.leads.left_m is None, "any plan is better"
            assert planning.is_plan_due(after, facts())
            again, _ = checking.check(after, predicting(line, NOW, seen=view()))
            assert again is after
        else:
            assert isinstance(after, Planning) and kinds(actions) == [Hover]
            assert after.because.sentence == "brake: 3.6 m from the trajectory"


def test_a_tracker_that_leads_away_from_the_trajectory_gets_a_new_plan():
    known = predicting(np.array(AHEAD) + [(0.0, min(3.0, 0.3 * i), 0.0) for i in range(40)], seen=view())
    after, actions = checking.check(moving_state(), known)
    assert after.because.reason is Reason.DEVIATED and not actions
    old = flight()
    after, actions = checking.check(moving_state(flight=replace(old, taken_s=NOW)), known)
    assert after.because is BECAUSE, "the prediction is older than the trajectory"


def test_a_tracker_that_leads_into_an_obstacle_is_braked_or_gets_a_new_plan_while_there_is_time():
    # At 2 m/s the vehicle stops within 2.2 m; with the margin and the next check 3.0 m, and a plan takes 2.4 m more.
    aside = np.array(AHEAD) + (0.0, 0.7, 0.0)
    near = moving_state(flight=replace(flight(), taken_s=NOW))
    after, actions = checking.check(near, predicting(aside, seen=view((4.0, 1.1))))
    assert isinstance(after, Planning) and kinds(actions) == [Hover]
    assert after.because.reason is Reason.UNSAFE_PREDICTION and "occupied in 2." in after.because.sentence
    after, actions = checking.check(near, predicting(aside, seen=view((5.6, 1.1))))
    assert isinstance(after, Moving) and not actions and after.because.reason is Reason.UNSAFE_PREDICTION
    assert after.plan_from_s == NOW + CONFIG.retry_interval_s, "the trajectory is new, so a plan has just been made"
    after, actions = checking.check(near, predicting(aside, seen=view((8.8, 1.1))))
    assert after.because is near.because and not actions, "a new prediction comes before"
    assert after.flight.left_s == NOW, "it is 0.7 m off the trajectory"


def test_a_vehicle_that_a_gust_brought_near_to_an_obstacle_is_not_stopped_there_if_its_way_leads_out():
    # A voxel begins 0.4 m behind the vehicle, nearer than the 0.5 m that are to be free around it.
    leaving = np.array(AHEAD) + (0.0, 0.4, 0.0)
    beside = view((0.4, 0.9))
    near = moving_state(flight=replace(flight(), taken_s=NOW))
    assert voxnav.check_corridor(beside, leaving, 0.5).first_unsafe_m == 0.0
    assert checking.check(near, predicting(leaving, seen=beside)) == (near, ())
    staying = np.column_stack([np.linspace(1.0, 1.2, 40), np.full(40, 0.4), np.full(40, 2.0)])
    after, actions = checking.check(near, predicting(staying, seen=beside))
    assert kinds(actions) == [Hover] and after.because.reason is Reason.UNSAFE_PREDICTION


def test_a_vehicle_that_still_moves_after_its_trajectory_is_checked():
    over = moving_state(flight=flight(begin_s=NOW - 30.0))
    assert checking.check(over, facts(seen=view())) == (over, ())
    after, actions = checking.check(over, facts(seen=view((2.4, 0.0))))
    assert isinstance(after, Planning) and kinds(actions) == [Hover] and after.because.reason is Reason.BRAKE
    assert checking.check(over, at_rest(seen=view((2.4, 0.0)))) == (over, ()), "it rests"


def test_a_way_of_somebody_else_that_is_not_free_is_told_but_not_stopped():
    idle = Idle(BECAUSE)
    after, actions = checking.check(idle, facts(seen=view((4.0, 0.0))))
    assert isinstance(after, Idle) and not actions and after.danger.reason is Reason.OTHERS_UNSAFE
    assert after.danger.reason.level is Level.WARN and "occupied in" in after.danger.sentence
    after, _ = checking.check(after, facts(seen=view()))
    assert after.danger is None
    landing = facts(seen=view((4.0, 0.0)), control=Control(False, False, False))
    assert checking.check(idle, landing) == (idle, ())


def turning(seen):
    """Returns a flight that is about to turn left at (3, 0), seen at 2 m/s, and the facts of it."""
    line = [(0.4 * i, 0.0, 2.0) for i in range(8)] + [(2.8, 0.4 * i, 2.0) for i in range(1, 8)]
    turn = replace(flight(), trajectory=voxnav.Trajectory(np.array(line), 0.2))
    return turn, facts(seen=seen)


def test_the_simplest_free_stop_is_taken():
    turn, known = turning(view())
    stopping_, hover = stops.stop_for(BECAUSE, turn, known)
    assert hover.means is Means.HOVER and hover.because is BECAUSE and stopping_.means is Means.HOVER


def test_a_stop_follows_the_trajectory_where_straight_ahead_is_blocked():
    turn, known = turning(view((4.8, 0.0)))
    fast = facts(position=(2.2, 0.0, 2.0), velocity=(2.6, 0.0, 0.0), seen=known.look())
    _, hover = stops.stop_for(BECAUSE, turn, fast)
    assert hover.means is Means.FOLLOW and "along the trajectory" in hover.because.sentence
    assert np.allclose(hover.trajectory.points[0], (2.2, 0.0, 2.0)) and hover.trajectory.points[-1][1] > 0.5
    assert stops.best_stop(None, fast).means is not Means.FOLLOW


def test_a_stop_climbs_over_a_low_obstacle_that_is_too_near():
    known = facts(seen=view((5.4, 0.0), height_m=1.6), velocity=(3.0, 0.0, 0.0))
    _, hover = stops.stop_for(BECAUSE, None, known)
    assert hover.means is Means.CLIMB and hover.trajectory.points[-1][2] > 3.0
    _, hover = stops.stop_for(BECAUSE, None, facts(seen=view((5.4, 0.0)), velocity=(3.0, 0.0, 0.0)))
    assert "no known free way to rest" in hover.because.sentence


def test_unknown_space_is_less_dangerous_than_an_obstacle():
    for state, is_occupied in ((0, False), (2, True)):
        known = facts(seen=view((2.4, 0.0), state=state))
        occupied_mps, unsafe_mps = stops.best_stop(None, known).danger
        assert unsafe_mps > 0.0 and (occupied_mps > 0.0) == is_occupied


def test_without_a_map_or_a_recent_place_the_vehicle_hovers():
    assert stops.stop_for(BECAUSE, flight(), facts())[1].means is Means.HOVER
    old = facts(seen=view((2.4, 0.0)))
    old = replace(old, now_s=NOW + 5.0)
    assert stops.best_stop(flight(), old) is None


def test_every_way_to_rest_ends_at_rest_and_keeps_the_limits():
    rng = np.random.RandomState(3)
    for _ in range(50):
        velocity = rng.uniform((-4.0, -4.0, -2.0), (4.0, 4.0, 2.0))
        known = facts(velocity=velocity)
        for way in (ways.straight_way(known), ways.climbing_way(known, 3.0, 0.4), ways.climbing_way(known, 1.5, 0.0)):
            speeds = np.diff(way.points, axis=0) / way.dt_s
            changes = np.diff(speeds, axis=0) / way.dt_s
            assert np.linalg.norm(speeds[-1]) < 0.35
            assert np.hypot(changes[:, 0], changes[:, 1]).max() < 2.0 * CONFIG.deceleration_ratio + 1e-6
            assert np.abs(changes[:, 2]).max() < 1.0
        stopped = known.vehicle.position_O + velocity * 0.4
        free = np.linalg.norm(velocity[:2]) ** 2 / (2.0 * 2.0 * CONFIG.deceleration_ratio)
        moved = ways.straight_way(known).points[-1] - stopped
        assert np.hypot(moved[0], moved[1]) == pytest.approx(free, abs=0.05)


def test_a_hover_refused_in_motion_escalates_at_once():
    state = planning_state(hover=OwnHover(BECAUSE, NOW, means=Means.FOLLOW))
    for means in (Means.HOVER, Means.EHOVER):
        state, (hover,) = stopping.hover_answered(state, "refused", facts())
        assert hover.means is means and hover.is_repeat and state.hover.means is means
    told, _ = stopping.lose(Idle(BECAUSE, GOAL, state.hover), Because(Reason.NO_MAP, "no map"), facts())
    assert told.because.sentence == "hover: no map; hover fails: refused"
    state, actions = stopping.hover_answered(state, "refused", facts())
    assert not actions and "emergency hover fails: refused" in state.because.sentence
    state, (hover,) = main_loop.tick(state, facts(NOW + 1.1))
    assert hover.means is Means.HOVER, "after a pause it begins anew"


def test_an_emergency_hover_lasts_until_commands_are_allowed_again():
    state = planning_state(hover=OwnHover(BECAUSE, NOW, NOW, Means.EHOVER))
    refusing = Control(is_flying=True, accepts_goals=False, is_tracking=False)
    after, actions = main_loop.tick(state, at_rest(NOW + 60.0, control=refusing))
    assert after.hover is not None and after.goal is not None and not actions
    after, _ = main_loop.tick(state, at_rest(NOW + 60.0))
    assert after.hover is None


def test_a_stop_whose_way_is_closed_is_replaced_once():
    braking = planning_state(hover=OwnHover(BECAUSE, NOW - 0.1, NOW - 0.1))
    seen = view((5.4, 0.0), height_m=1.6)
    line = [(1.0 + 0.6 * i, 0.0, 2.0) for i in range(10)]
    known = predicting(line, velocity=(3.0, 0.0, 0.0), seen=seen)
    after, (hover,) = checking.check(braking, known)
    assert hover.means is Means.CLIMB and after.hover.is_second_choice
    accepted, _ = stopping.hover_answered(after, "", known)
    assert checking.check(accepted, known) == (accepted, ())
    assert checking.check(braking, facts(seen=view())) == (braking, ())


def generated_line(line, stamp_s=None, dt_s=0.2):
    return Generated(voxnav.Trajectory(np.array(line, dtype=float), dt_s), stamp_s)


LINE = [(0.4 * i, 0.0, 2.0) for i in range(31)]


@pytest.mark.parametrize("generated, words", [
    (generated_line(LINE, NOW - 7.0), "answered 1.0 s too late"),
    (generated_line([(x, 2.5, z) for x, _, z in LINE]), "begins 2.5 m from the vehicle"),
    (generated_line(LINE, NOW - 3.0), "begins 1.8 m from the vehicle"),
    (generated_line(LINE[:-5]), "ends 2.0 m from the place"),
    (generated_line(LINE[:10] + LINE[15:]), "jumps, at 12.0 m/s")])
def test_a_generator_that_answers_with_something_else_is_refused_with_a_reason(generated, words):
    state = planning_state(job=generating())
    after, actions = flying.generate_done(state, JOB, generated, at_rest(seen=view()))
    assert not actions and after.because.reason is Reason.GENERATOR_FAILED and words in after.because.sentence


def test_the_stamp_of_the_generator_is_published_and_the_flight_begins_then():
    state = planning_state(job=generating())
    after, (publish,) = flying.generate_done(state, JOB, generated_line(LINE, NOW - 0.5), facts(seen=view()))
    assert publish.stamp_s == NOW - 0.5
    after, _ = flying.publish_done(after, JOB, "", facts(NOW + 0.3))
    assert after.flight.begin_s == NOW - 0.5 and after.flight.taken_s == NOW + 0.3
    assert after.flight.arc_m(np.array((1.6, 0.0, 2.0)), NOW + 0.3) == pytest.approx(1.6)


def test_only_what_is_not_over_is_checked_and_a_cut_trajectory_begins_now():
    state = planning_state(job=generating())
    known = facts(position=(2.0, 0.0, 2.0), seen=view((11.0, 0.0)))
    _, (publish,) = flying.generate_done(state, JOB, generated_line(LINE, NOW - 1.0), known)
    assert publish.stamp_s == NOW and np.allclose(publish.trajectory.points[0], (2.0, 0.0, 2.0))
    behind = facts(position=(2.4, 0.0, 2.0), seen=view((0.0, 0.9)))
    _, (publish,) = flying.generate_done(state, JOB, generated_line(LINE, NOW - 1.2), behind)
    assert publish.stamp_s == NOW - 1.2, "an obstacle beside the part that is over does not matter"


def test_a_stamp_of_the_future_counts_as_now():
    _, (publish,) = flying.generate_done(planning_state(job=generating()), JOB, generated_line(LINE, NOW + 9.0),
                                         at_rest(seen=view()))
    assert publish.stamp_s == NOW


@pytest.mark.parametrize("state", ANY)
def test_answers_to_jobs_that_no_longer_matter_are_ignored(state):
    assert planning.plan_done(state, JOB + 1, outcome(), facts()) == (state, ())
    assert flying.generate_done(state, JOB + 1, GENERATED, facts(seen=view())) == (state, ())
    assert flying.publish_done(state, JOB + 1, "refused", facts()) == (state, ())


def test_the_table_names_functions_that_exist():
    rows = [line for line in package.__doc__.splitlines() if re.match(r"(any|Idle|P, M|Planning|Moving)  ", line)]
    assert len(rows) > 20
    for row in rows:
        name = row.split()[-1]
        modules = (stopping, takeover, main_loop, planning, flying, checking)
        assert any(hasattr(module, name) for module in modules) or row.endswith("   "), row
