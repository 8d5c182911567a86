# SPDX-License-Identifier: BSD-3-Clause
"""Transitions of a new trajectory: it is verified, published, and taken by the tracker."""

from dataclasses import replace
from typing import Any, Union

from voxnav._core import PlanOutcome, PlanStatus, SafePart, Trajectory, explain, safe_part
from voxnav.planning_manager.actions import Publish
from voxnav.planning_manager.facts import Facts, Step
from voxnav.planning_manager.generated import Generated, fault_of
from voxnav.planning_manager.planning import fail, moving
from voxnav.planning_manager.reasons import Because, Reason
from voxnav.planning_manager.states import Active, Flight, Generating, Idle, Leads, Publishing, State, own_hover
from voxnav.planning_manager.stopping import TOO_LATE, brake, hover_again
from voxnav.planning_manager.stops import stop_for
from voxnav.planning_manager.verdicts import MEANINGS

# Paths whose ends are nearer to each other than this end at the same place.
UNCUT_M = 0.1
NO_MAP = "no map to check against"
OUTSIDE = "goal dropped: the way to it leaves the safety area, at which the control manager cut the trajectory"


def generate_done(state: State, number: int, generated: Union[Generated, str], facts: Facts) -> Step:
    """Verifies the generated trajectory itself, and publishes its safe part.

    generated: the trajectory, or why there is none
    """
    if isinstance(state, Idle) or not isinstance(state.job, Generating) or state.job.job != number:
        return state, ()
    outcome = state.job.outcome
    problem = generated if isinstance(generated, str) else fault_of(generated, outcome, facts)
    if problem or isinstance(generated, str):
        return fail(state, Because(Reason.GENERATOR_FAILED, "trajectory generator: " + problem), facts), ()
    view = facts.look()
    if view is None:
        return fail(state, Because(Reason.GENERATOR_FAILED, "generated trajectory: " + NO_MAP), facts), ()
    # What lies in the past is skipped by the tracker.
    begin_arc_m = generated.arc_m(facts.now_s)
    part = safe_part_of(generated.trajectory, begin_arc_m, outcome.corridor_radius_m, view, facts)
    if part.trajectory is None or (part.problem and part.trajectory.length_m < facts.config.min_progress_m):
        return fail(state, Because(Reason.GENERATOR_FAILED, "generated trajectory is " + part.problem), facts), ()
    stamp_s = facts.now_s if part.problem and generated.stamp_s is not None else generated.begin_s(facts.now_s)
    leads = _leads(outcome, generated.trajectory.length_m - begin_arc_m - part.trajectory.length_m, bool(part.problem))
    because = _moving_because(outcome, leads)
    return publish(state, Publishing(facts.job, facts.now_s, part.trajectory, stamp_s, leads, because, False))


def _leads(outcome: PlanOutcome, cut_m: float, is_cut: bool) -> Leads:
    left_m = outcome.left_m + (cut_m if is_cut else 0.0)
    is_to_goal = outcome.is_to_goal and not is_cut
    # A path that was not cut ends where the search found the nearest place.
    is_nearest = not is_cut and abs(outcome.left_m - outcome.plan.remaining_m) < UNCUT_M
    is_last = is_to_goal or (MEANINGS[outcome.status].is_about_goal and is_nearest)
    return Leads(outcome.corridor_radius_m, is_to_goal, left_m, is_last)


def _moving_because(outcome: PlanOutcome, leads: Leads) -> Because:
    sentence = "moving to the goal" if leads.is_to_goal else "moving towards the goal"
    if outcome.is_known_way:
        return Because(Reason.MOVING, sentence + " along the known way home: the search has found no other")
    doubt = "" if outcome.status == PlanStatus.COMPLETE else ": " + explain(outcome.status)
    return Because(MEANINGS[outcome.status].reason, sentence + doubt)


def publish_done(state: State, number: int, problem: str, facts: Facts, is_modified: bool = False) -> Step:
    """Takes the tracker's answer: it flies the trajectory from now on, or has refused it.

    is_modified: the control manager has cut the trajectory at its safety area, or moved it into that. What is flown
    then is not what was verified, and the same goal would be answered the same way again.
    """
    if isinstance(state, Idle) or not isinstance(state.job, Publishing) or state.job.job != number:
        return _late(state, problem, facts)
    job = state.job
    if is_modified and not problem:
        stopping, hover = stop_for(Because(Reason.SAFETY_AREA, OUTSIDE), None, facts)
        return Idle(hover.because, None, stopping), (hover,)
    if problem and job.is_shortening:
        because = Because(Reason.BRAKE, "brake: shortened trajectory refused: " + problem)
        return brake(state, because, facts)
    if problem:
        return fail(state, Because(Reason.TRAJECTORY_REFUSED, "trajectory refused: " + problem), facts), ()
    begin_s = facts.now_s if job.stamp_s is None else job.stamp_s
    flight = Flight(job.trajectory, begin_s, job.leads, facts.goal_O(state.goal), job.begin_s, facts.now_s)
    if job.is_shortening:
        return replace(state, job=None, flight=flight, plan_from_s=facts.now_s), ()
    return moving(state, job.because, flight, facts.next_plan_s(flight)), ()


def publish(state: Active, job: Publishing) -> Step:
    """Hands a trajectory to the tracker."""
    action = Publish(job.job, job.trajectory, job.stamp_s, job.because, job.is_shortening)
    return replace(state, job=job), (action,)


def safe_part_of(trajectory: Trajectory, from_arc_m: float, radius_m: float, view: Any, facts: Facts) -> SafePart:
    return safe_part(facts.config, view, trajectory, from_arc_m, radius_m, facts.vehicle.velocity_O, facts.limits,
                     facts.now_s)


def _late(state: State, problem: str, facts: Facts) -> Step:
    """Stops a trajectory that the tracker took although the state no longer waits for it."""
    if problem or not isinstance(state, Idle) and isinstance(state.job, Publishing):
        return state, ()
    if own_hover(state) is not None:
        return hover_again(state, facts)
    if isinstance(state, Idle):
        return replace(state, late_s=facts.now_s), ()
    return brake(state, Because(Reason.BRAKE, TOO_LATE), facts)
