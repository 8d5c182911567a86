# SPDX-License-Identifier: BSD-3-Clause
"""Transitions around the flown trajectory: it is verified, published, checked and shortened."""

from dataclasses import replace
from typing import Any, Optional

from voxnav._core import PlanStatus, SafePart, Trajectory, explain, safe_part
from voxnav.planning_manager.actions import Publish
from voxnav.planning_manager.facts import Facts, Step
from voxnav.planning_manager.planning import fail, moving
from voxnav.planning_manager.reasons import Because, Reason
from voxnav.planning_manager.states import (Active, Flight, Generating, Idle, Leads, Planning, Publishing, State)
from voxnav.planning_manager.stopping import brake, own_hover

NO_MAP = "no map to check against"


def check(state: State, view: Any, facts: Facts) -> Step:
    """Checks that the corridor of the flown trajectory is known to be free; else shortens the flight, or brakes.

    view: voxnav.OccupancyView; None counts as unsafe
    """
    if isinstance(state, Idle) or facts.inputs.vehicle is None or facts.inputs.limits is None:
        return state, ()
    stopping = own_hover(state)
    flight = facts.flown(state.flight)
    if flight is None or (stopping is not None and stopping.accepted_s is None):
        return state, ()
    is_shortening = isinstance(state.job, Publishing) and state.job.is_shortening
    if is_shortening and state.job is not None and facts.now_s - state.job.begin_s < facts.config.reaction_time_s:
        return state, ()  # a shortened trajectory is on its way to the tracker
    arc_m = flight.arc_m(facts.vehicle.position_O, facts.now_s)
    part = _safe_part(flight.trajectory, arc_m, flight.leads.radius_m, view, facts)
    problem = NO_MAP if part is None else part.problem
    if not problem:
        return state, ()
    if part is None or part.trajectory is None or is_shortening:
        return brake(state, Because(Reason.BRAKE, "brake: " + problem), facts)
    because = Because(Reason.SHORTENED, "shortened: " + problem)
    shortened = Planning(because, state.goal, facts.now_s, None, flight, state.progress)
    return _publish(shortened, part.trajectory, Leads(flight.leads.radius_m, False, None), because, facts)


def generate_done(state: State, number: int, trajectory: Optional[Trajectory], problem: str, view: Any,
                  facts: Facts) -> Step:
    """Verifies the generated trajectory itself, and publishes its safe part.

    trajectory: None where there is a problem; view: None counts as unsafe
    """
    if isinstance(state, Idle) or not isinstance(state.job, Generating) or state.job.job != number:
        return state, ()
    outcome = state.job.outcome
    if problem or trajectory is None:
        sentence = "trajectory generator: " + (problem or "empty trajectory")
        return fail(state, Because(Reason.GENERATOR_FAILED, sentence), facts), ()
    part = _safe_part(trajectory, 0.0, outcome.corridor_radius_m, view, facts)
    unsafe = NO_MAP if part is None else part.problem
    safe = None if part is None else part.trajectory
    if safe is None or (unsafe and safe.length_m < facts.config.min_progress_m):
        return fail(state, Because(Reason.GENERATOR_FAILED, "generated trajectory is " + unsafe), facts), ()
    left_m = outcome.left_m + (trajectory.length_m - safe.length_m if unsafe else 0.0)
    leads = Leads(outcome.corridor_radius_m, outcome.is_to_goal and not unsafe, left_m)
    sentence = "moving to the goal" if leads.is_to_goal else "moving towards the goal"
    doubt = "" if outcome.status == PlanStatus.COMPLETE else ": " + explain(outcome.status)
    return _publish(state, safe, leads, Because(Reason.MOVING, sentence + doubt), facts)


def publish_done(state: State, number: int, problem: str, facts: Facts) -> Step:
    """Takes the tracker's answer: it flies the trajectory from now on, or has refused it."""
    if isinstance(state, Idle) or not isinstance(state.job, Publishing) or state.job.job != number:
        return _late(state, problem, facts)
    job = state.job
    if problem and job.is_shortening:
        because = Because(Reason.BRAKE, "brake: shortened trajectory refused: " + problem)
        return brake(state, because, facts)
    if problem:
        return fail(state, Because(Reason.TRAJECTORY_REFUSED, "trajectory refused: " + problem), facts), ()
    flight = Flight(job.trajectory, facts.now_s, job.leads, facts.goal_O(state.goal), job.begin_s)
    if job.is_shortening:
        return replace(state, job=None, flight=flight, plan_from_s=facts.now_s), ()
    from_s = facts.now_s + facts.config.replan_interval_s
    return moving(state, job.because, flight, from_s), ()


def _late(state: State, problem: str, facts: Facts) -> Step:
    """Stops a trajectory that the tracker took although the state no longer waits for it."""
    if problem or isinstance(state, Idle) or isinstance(state.job, Publishing) or own_hover(state) is not None:
        return state, ()
    because = Because(Reason.BRAKE, "brake: a trajectory was accepted too late")
    return brake(state, because, facts)


def _publish(state: Active, trajectory: Trajectory, leads: Leads, because: Because, facts: Facts) -> Step:
    is_shortening = because.reason is Reason.SHORTENED
    job = Publishing(facts.job, facts.now_s, trajectory, leads, because, is_shortening)
    return replace(state, job=job), (Publish(facts.job, trajectory, because, is_shortening),)


def _safe_part(trajectory: Trajectory, from_arc_m: float, radius_m: float, view: Any,
               facts: Facts) -> Optional[SafePart]:
    """Returns the safe part of a trajectory; None without a map."""
    if view is None:
        return None
    return safe_part(facts.config, view, trajectory, from_arc_m, radius_m, facts.vehicle.velocity_O, facts.limits)
