# SPDX-License-Identifier: BSD-3-Clause
"""Transitions of the search: it begins, and its path is flown, is not worth it, or decides about the goal."""

from dataclasses import replace

import numpy as np

from voxnav._core import PlanOutcome, PlanStatus, Trajectory, first_meeting
from voxnav.array_types import Array
from voxnav.planning_manager.actions import Generate, Plan
from voxnav.planning_manager.facts import Facts, Step
from voxnav.planning_manager.progress import GoalProgress
from voxnav.planning_manager.reasons import Because, Reason
from voxnav.planning_manager.states import (Active, Flight, Generating, Idle, Moving, Planning, Searching, State,
                                            own_hover)
from voxnav.planning_manager.stopping import stop
from voxnav.planning_manager.verdicts import MEANINGS, verdict_of


# A thing that comes nearer to the goal than this may be what blocks it; searches keep map/moving_clearance_m from it,
# measured to the middles of cells.
GOAL_ROOM_M = 1.5
# The vehicle would rest at the goal, so that the step of that trajectory has no meaning.
GOAL_STEP_S = 0.1


def is_plan_due(state: Active, facts: Facts) -> bool:
    """Returns True if no job is running, it is time, and the flown trajectory does not lead to the goal already.

    It is time at once when the map shows the goal's place as something else than before.
    """
    if state.job is not None:
        return False
    has_news = facts.goal_state(state.goal) != state.goal_state
    flight = facts.flown(state.flight)
    if facts.now_s < state.plan_from_s and not (has_news and flight is not None):
        return False
    return flight is None or not flight.leads.is_last or has_news or facts.has_goal_moved(flight, state.goal)


def start_plan(state: Active, facts: Facts) -> Step:
    """Starts a search from where the vehicle rests, or from where it will be once there is a trajectory."""
    flight = facts.flown(state.flight)
    start, stamp_s = facts.vehicle.position_O, None
    if flight is not None or facts.vehicle.speed_mps > facts.config.rest_speed_mps:
        stamp_s = facts.now_s + facts.config.planning_budget_s + facts.config.generation_budget_s
        predicted = facts.predicted(stamp_s)
        if predicted is None:
            return fail(state, Because(Reason.PLAN_FAILED, "tracker prediction is too short"), facts), ()
        start = predicted
    job = Searching(facts.job, facts.now_s, stamp_s)
    if flight is None:
        state = at_rest(state, state.because)
    state = replace(state, job=job, goal_state=facts.goal_state(state.goal))
    return state, (Plan(facts.job, start, facts.goal_O(state.goal)),)


def plan_done(state: State, number: int, outcome: PlanOutcome, facts: Facts) -> Step:
    """Passes the part of a found path that may be flown to the generator, if it is worth flying."""
    if isinstance(state, Idle) or not isinstance(state.job, Searching) or state.job.job != number:
        return state, ()
    start_stamp_s = state.job.start_stamp_s
    progress = state.progress or GoalProgress(facts.now_s)
    if len(outcome.plan.path):
        progress = progress.after_plan(_left_m(outcome), facts.now_s)
    state = replace(state, job=None, progress=progress)
    waypoints = outcome.waypoints_O
    if len(waypoints) == 0 or not MEANINGS[outcome.status].leads_near:
        return no_way(state, outcome, facts)
    if not is_worth_flying(state, outcome, facts):
        flight = facts.flown(state.flight)
        if flight is None:
            return no_way(state, outcome, facts)
        return replace(state, plan_from_s=facts.next_plan_s(flight)), ()
    heading = facts.heading_O(state.goal) if outcome.is_to_goal else None
    job = Generating(facts.job, facts.now_s, outcome)
    return replace(state, job=job), (Generate(facts.job, waypoints, start_stamp_s, heading),)


def plan_failed(state: State, number: int, problem: str, facts: Facts) -> Step:
    """Handles a search that could not be made: for want of a map, or of memory for it."""
    if isinstance(state, Idle) or not isinstance(state.job, Searching) or state.job.job != number:
        return state, ()
    return fail(state, Because(Reason.PLAN_FAILED, "no search: " + problem), facts), ()


def no_way(state: Active, outcome: PlanOutcome, facts: Facts) -> Step:
    """Tries again after a search that found nothing worth flying, or gives the goal up once that is decided."""
    if MEANINGS[outcome.status].is_about_goal and is_goal_crossed(state, facts):
        because = Because(Reason.PLAN_FAILED, "waits: something that moves is at the goal, or comes there")
        return replace(fail(state, because, facts), verdict=None), ()
    leads_nowhere = _length_m(outcome.plan.path) < facts.config.min_progress_m or len(outcome.waypoints_O) > 0
    is_resting = leads_nowhere and facts.flown(state.flight) is None
    verdict = verdict_of(state.verdict, outcome, is_resting, facts.now_s)
    if verdict is not None and verdict.is_final(facts.now_s):
        return stop(state, verdict.because, facts)
    is_told = verdict is not None and verdict.confirm_s is not None
    because = verdict.because if verdict is not None and is_told else Because(Reason.PLAN_FAILED, outcome.problem)
    return replace(fail(state, because, facts), verdict=verdict), ()


def is_goal_crossed(state: Active, facts: Facts) -> bool:
    """Returns True if something that moves may soon be at the goal, which then decides nothing about the goal.

    If it does not go away, the goal is given up like any other to which there is no progress.
    """
    view = facts.look()
    if view is None:
        return False
    at_goal = Trajectory(np.array([facts.goal_O(state.goal)]), GOAL_STEP_S)
    return first_meeting(view, at_goal, facts.now_s, GOAL_ROOM_M) is not None


def is_worth_flying(state: Active, outcome: PlanOutcome, facts: Facts) -> bool:
    """Returns True if a path leads clearly nearer to the goal than the flown trajectory, or if that is no longer good.

    This keeps the vehicle from alternating between paths of similar length. A vehicle at rest beside a goal that cannot
    be reached is not moved by less than min_progress_m either.
    """
    flight = facts.flown(state.flight)
    is_about_goal = MEANINGS[outcome.status].is_about_goal
    if outcome.is_to_goal:
        return True
    if flight is None:
        here_m = float(np.linalg.norm(facts.vehicle.position_O - facts.goal_O(state.goal)))
        return not is_about_goal or bool(outcome.plan.remaining_m < here_m - facts.config.min_progress_m)
    if flight.leads.left_m is None or (flight.leads.is_to_goal and is_about_goal):
        return True
    is_nearer = outcome.left_m < flight.leads.left_m - facts.config.min_progress_m
    return bool(is_nearer) or facts.has_goal_moved(flight, state.goal)


def fail(state: Active, because: Because, facts: Facts) -> Active:
    """Handles a failed plan: the present flight continues, and planning is tried again."""
    flight = facts.flown(state.flight)
    from_s = facts.now_s + facts.config.retry_interval_s
    if flight is None:
        return replace(at_rest(state, because), job=None, plan_from_s=from_s)
    return moving(state, because, flight, from_s)


def at_rest(state: Active, because: Because) -> Planning:
    """Returns the state Planning without a flight."""
    return Planning(because, state.goal, state.plan_from_s, state.job, None, state.progress, own_hover(state),
                    state.verdict, state.goal_state)


def moving(state: Active, because: Because, flight: Flight, plan_from_s: float) -> Moving:
    """Returns the state Moving along a flight, without a job."""
    return Moving(because, state.goal, flight, plan_from_s, None, state.progress, None, state.goal_state)


def _left_m(outcome: PlanOutcome) -> float:
    """Returns the way left to the goal: the path, and the straight line from its end if it does not reach the goal."""
    gap_m = 0.0 if outcome.status == PlanStatus.COMPLETE else outcome.plan.remaining_m
    return _length_m(outcome.plan.path) + float(gap_m)


def _length_m(path: Array) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
