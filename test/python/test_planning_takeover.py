# SPDX-License-Identifier: BSD-3-Clause
"""Whoever else commands the vehicle has it: the goal is dropped, the reason says who, and nothing is commanded."""

from dataclasses import replace

import numpy as np
import pytest

import voxnav
from voxnav.planning_manager import Because, Hover, Idle, Means, Moving, Planning, Reason
from voxnav.planning_manager import checking, flying, input_ids, main_loop, stopping, takeover
from voxnav.planning_manager.inputs import Control, Prediction, Timed, TrackerState
from voxnav.planning_manager.owners import who_flies
from voxnav.planning_manager.states import Goal, OwnHover
from test_planning_transitions import (BECAUSE, FREE, GOAL, JOB, NOW, TRAJECTORY, at_rest, facts, flight, inputs, kinds,
                                       moving_state, planning_state, publishing, view)

OURS, THEIRS = input_ids.FIRST_ID + 3, 7
RESTING = Control(is_flying=True, accepts_goals=True, is_tracking=False)
TAKEN = {
    "remote control": Control(False, False, False, is_remote=True, state=TrackerState.REFERENCE),
    "the bumper": Control(False, False, False, is_repelling=True, state=TrackerState.REFERENCE),
    "the vehicle lands": Control(False, False, False, state=TrackerState.LAND),
    "landed": Control(False, False, False, has_output=False, state=TrackerState.IDLE),
    "LandoffTracker with FailsafeController": Control(False, False, False, state=TrackerState.HOVER,
                                                      tracker="LandoffTracker", controller="FailsafeController"),
    "callbacks are disabled": Control(False, True, True, state=TrackerState.TRAJECTORY),
    "callbacks of the tracker": Control(True, False, False, state=TrackerState.HOVER)}


def told(control, input_id=None, way=(0.0, 0.0, 0.0), now=NOW, **kwargs):
    """Returns facts with these diagnostics, and a prediction with this input_id that leads along this way."""
    out = facts(now, control=control, **kwargs)
    times = now + 0.1 * np.arange(60)
    line = np.array([1.0, 0.0, 2.0]) + np.outer(np.linspace(0.0, 1.0, 60), way)
    return replace(out, inputs=replace(out.inputs, prediction=Timed(now, Prediction(times, line, input_id))))


@pytest.mark.parametrize("state", [moving_state(), planning_state(), planning_state(job=publishing()),
                                   Idle(BECAUSE, GOAL)], ids=["moving", "planning", "publishing", "idle"])
@pytest.mark.parametrize("words", TAKEN)
def test_the_goal_is_dropped_with_the_name_of_who_has_the_vehicle(state, words):
    after, actions = main_loop.tick(state, facts(control=TAKEN[words]))
    assert isinstance(after, Idle) and after.goal is None and not actions
    assert after.because.reason is Reason.TAKEN_OVER and words in after.because.sentence
    again, actions = main_loop.tick(after, facts(NOW + 20.0))
    assert isinstance(again, Idle) and again.goal is None and not actions


@pytest.mark.parametrize("words", sorted(set(TAKEN) - {"landed", "callbacks of the tracker"}))
def test_a_vehicle_that_others_fly_is_not_on_the_ground_and_is_not_told_to_hover(words):
    taken = facts(control=TAKEN[words])
    assert taken.inputs.is_in_air and not taken.inputs.is_on_ground
    state = Idle(BECAUSE, None, OwnHover(BECAUSE, NOW - 5.0))
    after, actions = main_loop.tick(state, taken)
    assert after.hover is None and not actions
    after, actions = stopping.hover_answered(state, "callbacks are disabled", taken)
    assert not actions, "an emergency hover would take the vehicle from the pilot"


@pytest.mark.parametrize("words", sorted(set(TAKEN) - {"landed", "callbacks of the tracker"}))
def test_a_goal_that_is_set_meanwhile_waits_and_says_for_whom(words):
    early = replace(GOAL, has_been_free=False)
    for state in (replace(moving_state(), goal=early), replace(planning_state(), goal=early), Idle(BECAUSE, early)):
        after, actions = main_loop.tick(state, facts(control=TAKEN[words]))
        assert isinstance(after, Idle) and after.goal is early and not actions
        assert after.because.sentence == "waiting: " + who_flies(TAKEN[words]).sentence
        assert after.because.reason.level.name == "WARN"


def test_a_trajectory_of_another_node_is_known_by_its_input_id():
    assert not input_ids.is_own(THEIRS) and input_ids.is_own(OURS)
    assert input_ids.is_own(input_ids.after(OURS)) and input_ids.is_own(input_ids.after(input_ids.LAST_ID))
    for state in (moving_state(flight=flight(NOW - 2.0)), planning_state(), Idle(BECAUSE, GOAL)):
        after, actions = main_loop.tick(state, told(FREE, THEIRS))
        assert after.because.reason is Reason.TAKEN_OVER and "input_id 7" in after.because.sentence and not actions
        for known in (OURS, None):
            assert main_loop.tick(state, told(FREE, known))[0].goal is not None


@pytest.mark.parametrize("state", [
    moving_state(flight=flight(NOW - 0.3)), planning_state(job=publishing()),
    planning_state(hover=OwnHover(BECAUSE, NOW - 0.5, NOW - 0.4))], ids=["just taken", "publishing", "own stop"])
def test_what_may_be_an_own_command_is_not_taken_for_another(state):
    """The tracker has taken the trajectory, but the prediction, or the answer, is from before."""
    assert takeover.taken_over(state, told(FREE, THEIRS)) is None


def test_a_reference_to_a_vehicle_at_rest_is_known_by_where_it_leads():
    moving_on = replace(RESTING, has_goal=True)
    after, actions = main_loop.tick(planning_state(), told(moving_on, OURS, way=(4.0, 3.0, 0.0)))
    assert after.because.reason is Reason.TAKEN_OVER and "5.0 m away" in after.because.sentence and not actions
    climbing, near = told(moving_on, OURS, way=(0.0, 0.0, 3.0)), told(moving_on, OURS, way=(1.0, 0.0, 0.0))
    for own in (climbing, near, told(RESTING, OURS, way=(5.0, 0.0, 0.0))):
        assert takeover.taken_over(planning_state(), own) is None
    over = flight(begin_s=NOW - 1.0 - TRAJECTORY.duration_s)
    assert takeover.taken_over(moving_state(flight=over), told(moving_on, OURS, way=(5.0, 0.0, 0.0))) is None
    over = flight(begin_s=NOW - 2.1 - TRAJECTORY.duration_s)
    assert takeover.taken_over(moving_state(flight=over), told(moving_on, OURS, way=(5.0, 0.0, 0.0))) is not None


def test_a_reference_just_after_a_trajectory_was_taken_is_noticed_although_it_was_never_seen_flown():
    state = moving_state(flight=flight(NOW - 0.8, is_tracked=False))
    assert takeover.taken_over(state, told(RESTING, OURS)) == "somebody else commands the vehicle"
    assert takeover.taken_over(moving_state(flight=flight(NOW - 0.3, is_tracked=False)), told(RESTING, OURS)) is None


def test_diagnostics_from_before_a_trajectory_show_the_hover_of_voxnav_that_it_ended():
    hovering = Control(True, False, False, state=TrackerState.HOVER)
    state = moving_state(flight=flight(NOW - 0.1, is_tracked=False))
    assert takeover.taken_over(state, told(hovering, OURS)) is None
    later = moving_state(flight=flight(NOW - 0.6, is_tracked=False))
    assert "let the vehicle hover" in takeover.taken_over(later, told(hovering, OURS))


def test_a_prediction_that_leaves_the_trajectory_is_judged_once_diagnostics_tell_who_commands():
    """The tracker is led into unknown space by another node, which its prediction shows before its diagnostics."""
    def seen(now, control_s):
        out = told(FREE, OURS, way=(0.0, 0.0, 30.0), now=now, seen=view())
        return replace(out, inputs=replace(out.inputs, control=Timed(control_s, FREE)))
    waiting, actions = checking.check(moving_state(), seen(NOW, NOW - 0.08))
    assert isinstance(waiting, Moving) and not actions and waiting.flight.left_s == NOW
    waiting, actions = checking.check(waiting, seen(NOW + 0.1, NOW - 0.08))
    assert isinstance(waiting, Moving) and not actions and waiting.flight.left_s == NOW
    later = NOW + 0.2
    after, actions = main_loop.tick(waiting, told(RESTING, OURS, way=(0.0, 0.0, 30.0), now=later, seen=view()))
    assert after.because.reason is Reason.TAKEN_OVER and not actions
    for now, control_s in ((later, later - 0.05), (NOW + 0.3, NOW - 0.08)):  # it is voxnav's own, or nobody tells
        after, actions = checking.check(waiting, seen(now, control_s))
        assert [type(a) for a in actions] == [Hover], now
    on_it, _ = checking.check(waiting, facts(NOW + 0.1, position=(1.2, 0.0, 2.0), seen=view()))
    assert on_it.flight.left_s is None


def test_a_new_goal_takes_the_vehicle_back_from_a_reference_of_another_node():
    """The goal was set while the reference was flown, so whoever set it wants voxnav to fly."""
    new = Goal(GOAL.position_W, None)
    theirs = told(replace(RESTING, has_goal=True), THEIRS, way=(5.0, 0.0, 0.0), seen=view())
    state, _ = stopping.accept_goal(Idle(BECAUSE), new, theirs)
    state, actions = main_loop.tick(state, theirs)
    assert isinstance(state, Planning) and not state.goal.has_been_free and [a.name for a in actions] == ["plan"]
    flown = replace(moving_state(flight=flight(NOW - 1.0)), goal=new)
    after, _ = main_loop.tick(flown, told(FREE, OURS))
    assert isinstance(after, Moving) and after.goal.has_been_free


def test_an_emergency_hover_of_voxnav_is_not_taken_for_that_of_somebody_else():
    state = planning_state(hover=OwnHover(BECAUSE, NOW - 1.0, NOW - 0.9, Means.EHOVER))
    after, actions = main_loop.tick(state, facts(control=TAKEN["LandoffTracker with FailsafeController"]))
    assert after.goal is None and not actions
    assert "after the emergency hover of voxnav a person has to allow commands again" in after.because.sentence


@pytest.mark.parametrize("is_shortening", [False, True])
def test_a_trajectory_cut_at_the_safety_area_drops_the_goal_and_names_the_area(is_shortening):
    state = planning_state(job=publishing(is_shortening))
    after, actions = flying.publish_done(state, JOB, "", facts(seen=view()), is_modified=True)
    assert isinstance(after, Idle) and after.goal is None and kinds(actions) == [Hover]
    assert after.because.reason is Reason.SAFETY_AREA and "safety area" in after.because.sentence
    after, actions = flying.publish_done(planning_state(job=publishing()), JOB, "refused", facts(), is_modified=True)
    assert after.goal is not None and not actions


def test_the_status_tells_who_has_the_vehicle_and_where_it_is_not_safe():
    manager = voxnav.PlanningManager(voxnav.PlanningManagerConfig(), (-5.0, 20.0), lambda: None)
    danger = Because(Reason.OTHERS_UNSAFE, "flown by somebody else: not known free")
    for reason, words in ((Reason.TAKEN_OVER, "for the test; flown by somebody else: not known free"),
                          (Reason.STOPPED, "flown by somebody else: not known free")):
        manager._state = Idle(Because(reason, "for the test"), danger=danger)
        assert manager.status.reason == words and manager.status.because.reason is Reason.OTHERS_UNSAFE


def test_at_rest_nothing_is_taken_over():
    assert takeover.taken_over(planning_state(), replace(at_rest(), inputs=inputs(control=RESTING))) is None
