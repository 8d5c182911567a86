# SPDX-License-Identifier: BSD-3-Clause
"""The main loop: who has the vehicle, what is missing, arrival, progress, and whether a plan is due."""

from dataclasses import replace
from typing import Optional, Union

import numpy as np

from voxnav.planning_manager.facts import Facts, Step
from voxnav.planning_manager.planning import fail, is_plan_due, start_plan
from voxnav.planning_manager.progress import GoalProgress
from voxnav.planning_manager.reasons import Because, Reason
from voxnav.planning_manager.states import (Active, Generating, Goal, Idle, Moving, Planning, Publishing, Searching,
                                            State)
from voxnav.planning_manager.stopping import is_flown_by_others, lose, repeat_hover, stop, stop_late
from voxnav.planning_manager.takeover import drop_goal, taken_over, watch


def tick(state: State, facts: Facts) -> Step:
    """Makes one step of the main loop. Its rules are tried in order; the first one that applies decides."""
    state = watch(state, facts)
    theirs = taken_over(state, facts)
    if theirs is not None:
        return drop_goal(theirs)
    if not isinstance(state, Moving) and state.hover is not None and is_flown_by_others(facts):
        state = replace(state, hover=None)  # a vehicle on the ground, or flown by somebody else, is not to hover
    stopping = stop_late(state, facts) or repeat_hover(state, facts)
    if stopping is not None:
        return stopping
    missing = facts.missing()
    if missing is not None:
        return lose(state, missing, facts)
    if state.goal is None:
        return state, ()
    if isinstance(state, Idle):
        state = resume(state, state.goal, facts)
    arrived = arrival(state, facts)
    if arrived is not None:
        return arrived
    if state.job is not None and facts.now_s - state.job.begin_s > facts.config.job_timeout_s:
        return fail(state, Because(Reason.NO_ANSWER, _who(state.job) + " does not answer"), facts), ()
    state = with_progress(state, facts)
    tired = give_up(state, facts)
    if tired is not None:
        return tired
    return start_plan(state, facts) if is_plan_due(state, facts) else (state, ())


def resume(state: Idle, goal: Goal, facts: Facts) -> Planning:
    """Resumes the flight to a kept goal once nothing is missing any more."""
    return Planning(Because(Reason.RESUMED, "flight resumes"), goal, facts.now_s, hover=state.hover)


def arrival(state: Active, facts: Facts) -> Optional[Step]:
    """Ends the flight if the vehicle rests at the goal; None as long as it does not."""
    distance_m = float(np.linalg.norm(facts.vehicle.position_O - facts.goal_O(state.goal)))
    is_rest = facts.vehicle.speed_mps < facts.config.rest_speed_mps and facts.flown(state.flight) is None
    if distance_m > facts.config.goal_tolerance_m or not is_rest:
        return None
    return Idle(Because(Reason.REACHED, "goal reached, %.2f m from it" % distance_m)), ()


def with_progress(state: Active, facts: Facts) -> Active:
    """Records how much of the way to the goal is left on the flown trajectory."""
    progress = state.progress or GoalProgress(facts.now_s)
    flight = facts.flown(state.flight)
    if flight is not None and flight.leads.left_m is not None:
        left_m = float(flight.trajectory.length_m) - flight.arc_m(facts.vehicle.position_O, facts.now_s)
        progress = progress.after(left_m + flight.leads.left_m, facts.now_s)
    return replace(state, progress=progress)


def give_up(state: Active, facts: Facts) -> Optional[Step]:
    """Gives the goal up if the vehicle does not come nearer to it; None as long as it does."""
    problem = "" if state.progress is None else state.progress.problem(facts.now_s, facts.config)
    if not problem:
        return None
    stuck = Because(Reason.STUCK, "stuck: %s: %s" % (problem, state.because.sentence))
    return stop(state, stuck if state.verdict is None else state.verdict.because, facts)


def _who(job: Union[Searching, Generating, Publishing]) -> str:
    return {Searching: "search", Generating: "trajectory generator", Publishing: "trajectory service"}[type(job)]
