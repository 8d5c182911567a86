# SPDX-License-Identifier: BSD-3-Clause
"""Transitions of the check that runs every 100 ms: whatever the vehicle flies must lead to rest in known free space.

Checked are the trajectory from where the vehicle is, its distance from there, the tracker's own prediction, and the
way from the vehicle to it; without a trajectory the prediction alone, whoever commands the vehicle.
"""

from dataclasses import replace
from typing import Any, Optional

from voxnav._core import CorridorResult, Trajectory, check_corridor
from voxnav.planning_manager.actions import Means
from voxnav.planning_manager.facts import Facts, Step
from voxnav.planning_manager.flying import NO_MAP, publish, safe_part_of
from voxnav.planning_manager.reasons import Because, Reason
from voxnav.planning_manager.states import (Active, Flight, Idle, Leads, OwnHover, Planning, Publishing, State,
                                            own_hover)
from voxnav.planning_manager.stopping import brake
from voxnav.planning_manager.stops import asked_for, best_stop, danger_in_steps
from voxnav.planning_manager.takeover import taken_over
from voxnav.planning_manager.ways import straight_way, way_ahead

# Nearer than this along its way, the vehicle is beside the unsafe place already.
BESIDE_M = 0.05
# The next check comes after this time at the latest.
NEXT_CHECK_S = 0.2
# The tracker's prediction is compared with the trajectory at these times from now.
AHEAD_S = (0.0, 0.5, 1.0, 2.0)
# A prediction shows a trajectory if it was made this much after the tracker took it.
SHOWN_S = 0.1
# A vehicle, or a place that is predicted for it, has left its trajectory if it is farther from it than this.
DEPARTURE_M = 0.4
# Diagnostics come ten times a second: within this time they tell whether somebody else leads a tracker off its way.
OWNER_SHOWS_S = 0.25


def check(state: State, facts: Facts) -> Step:
    """Checks what the vehicle flies; shortens the flight, brakes or plans anew where it is not safe."""
    if facts.inputs.vehicle is None or facts.inputs.limits is None:
        return state, ()
    if taken_over(state, facts) is not None:
        return state, ()  # the next tick drops the goal; a stop would take the vehicle from whoever has it
    stopping = own_hover(state)
    if stopping is not None:
        return check_stop(state, stopping, facts)
    if isinstance(state, Idle):
        return check_others(state, facts)
    flight = facts.flown(state.flight)
    return check_rest(state, facts) if flight is None else check_flight(state, flight, facts)


def check_flight(state: Active, flight: Flight, facts: Facts) -> Step:
    """Checks the flown trajectory, the vehicle's distance from it, and what the tracker makes of it."""
    is_shortening = isinstance(state.job, Publishing) and state.job.is_shortening
    if is_shortening and state.job is not None and facts.now_s - state.job.begin_s < facts.config.reaction_time_s:
        return state, ()  # a shortened trajectory is on its way to the tracker
    view = facts.look()
    if view is None:
        return brake(state, Because(Reason.BRAKE, "brake: " + NO_MAP), facts)
    shortened = _check_trajectory(state, flight, view, facts)
    if shortened is not None:
        return shortened
    deviation_m = deviation_of(flight, facts)
    if (deviation_m > DEPARTURE_M) != (flight.left_s is not None):
        flight = replace(flight, left_s=facts.now_s if flight.left_s is None else None)
        state = replace(state, flight=flight)
    if _may_be_taken_over(flight, facts):
        return state, ()
    if deviation_m > facts.config.brake_deviation_m:
        sentence = "brake: %.1f m from the trajectory" % deviation_m
        return brake(state, Because(Reason.DEVIATED, sentence), facts)
    predicted = _check_prediction(state, flight, view, facts)
    if predicted is not None:
        return predicted
    if deviation_m > facts.config.replan_deviation_m:
        because = Because(Reason.DEVIATED, "plans anew: %.1f m from the trajectory" % deviation_m)
        return plan_anew(state, flight, because, facts), ()
    return state, ()


def _may_be_taken_over(flight: Flight, facts: Facts) -> bool:
    """Returns True until diagnostics tell whether it is a command of another node that leads off the trajectory.

    A prediction shows such a command before the diagnostics do. Braking at once would take the vehicle from a person.
    """
    if flight.left_s is None or facts.control is None or facts.now_s - flight.left_s > OWNER_SHOWS_S:
        return False
    return facts.control.stamp_s < flight.left_s


def plan_anew(state: Active, flight: Flight, because: Because, facts: Facts) -> Active:
    """Lets any new plan replace a flight that is no longer as it was planned; the vehicle flies on meanwhile."""
    if flight.leads.left_m is None and not flight.leads.is_last:
        return state  # a plan is due already
    leads = Leads(flight.leads.radius_m, False, None)
    from_s = max(facts.now_s, flight.taken_s + facts.config.retry_interval_s)
    return replace(state, because=because, flight=replace(flight, leads=leads), plan_from_s=from_s)


def check_rest(state: Active, facts: Facts) -> Step:
    """Checks the way to rest of a vehicle that still moves after its trajectory, or before there is one."""
    problem = _problem_ahead(facts)
    return brake(state, Because(Reason.BRAKE, "brake: " + problem), facts) if problem else (state, ())


def check_stop(state: State, stopping: OwnHover, facts: Facts) -> Step:
    """Checks the way of an accepted stop; if it is not free, once another means may be tried that is clearly better."""
    is_settled = stopping.accepted_s is None or stopping.is_second_choice or stopping.means is Means.EHOVER
    if is_settled or not _problem_ahead(facts):
        return state, ()
    stop, view = best_stop(None, facts), facts.look()
    if stop is None or stop.means is stopping.means:
        return state, ()
    now = danger_in_steps(way_ahead(facts), view, facts.config.min_corridor_radius_m, facts.now_s)
    if not stop.danger < now:
        return state, ()
    second, hover = asked_for(stop, stopping.because, facts)
    return replace(state, hover=replace(second, is_second_choice=True)), (hover,)


def check_others(state: Idle, facts: Facts) -> Step:
    """Tells if somebody else flies the vehicle where it is not known to be free; voxnav does not interfere."""
    problem = _problem_ahead(facts) if facts.inputs.is_in_air else ""
    danger = Because(Reason.OTHERS_UNSAFE, "flown by somebody else: " + problem) if problem else None
    return (state if danger is None and state.danger is None else replace(state, danger=danger)), ()


def deviation_of(flight: Flight, facts: Facts) -> float:
    """Returns the largest distance from the trajectory of the vehicle, and of the places that the tracker predicts."""
    distances = [flight.deviation_m(facts.vehicle.position_O, facts.now_s)]
    prediction = facts.inputs.prediction
    if prediction is not None and prediction.stamp_s > flight.taken_s + SHOWN_S:
        for ahead_s in AHEAD_S:
            predicted = facts.predicted(facts.now_s + ahead_s)
            if predicted is not None:
                distances.append(flight.deviation_m(predicted, facts.now_s + ahead_s))
    return max(distances)


def _check_trajectory(state: Active, flight: Flight, view: Any, facts: Facts) -> Optional[Step]:
    """Shortens a flight whose corridor is not known to be free, or brakes; None if it is free."""
    arc_m = flight.arc_m(facts.vehicle.position_O, facts.now_s)
    part = safe_part_of(flight.trajectory, arc_m, flight.leads.radius_m, view, facts)
    if not part.problem:
        return None
    is_shortening = isinstance(state.job, Publishing) and state.job.is_shortening
    if part.trajectory is None or is_shortening:
        return brake(state, Because(Reason.BRAKE, "brake: " + part.problem), facts)
    because = Because(Reason.SHORTENED, "shortened: " + part.problem)
    shortened = Planning(because, state.goal, facts.now_s, None, flight, state.progress)
    leads = Leads(flight.leads.radius_m, False, None)
    return publish(shortened, Publishing(facts.job, facts.now_s, part.trajectory, facts.now_s, leads, because, True))


def _check_prediction(state: Active, flight: Flight, view: Any, facts: Facts) -> Optional[Step]:
    """Brakes where the tracker leads into space that is not known free, or plans anew while there is time for it.

    The corridor is smaller than that of the trajectory by what the flight may deviate from it. Farther ahead the
    prediction does not matter yet, because a new one comes before the vehicle does.
    """
    radius_m = flight.leads.radius_m - facts.config.trajectory_deviation_m
    seen = _first_unsafe(way_ahead(facts), view, max(0.0, radius_m))
    if seen is None:
        return None
    text = "the tracker leads where it is " + _place(seen)
    speed, config = facts.vehicle.speed_mps, facts.config
    stopping_m = straight_way(facts).length_m + config.stop_margin_m + speed * NEXT_CHECK_S
    if seen.first_unsafe_m < stopping_m:
        return brake(state, Because(Reason.UNSAFE_PREDICTION, "brake: " + text), facts)
    if seen.first_unsafe_m < stopping_m + speed * (config.planning_budget_s + config.generation_budget_s):
        because = Because(Reason.UNSAFE_PREDICTION, "plans anew: " + text)
        return plan_anew(state, flight, because, facts), ()
    return None


def _problem_ahead(facts: Facts) -> str:
    """Tells where the way ahead of a moving vehicle is not known to be free; '' if it is free, or cannot be checked."""
    view = facts.look()
    if view is None or not facts.is_vehicle_known:
        return ""
    way = way_ahead(facts)
    if not facts.is_in_motion and way.length_m < facts.config.min_corridor_radius_m:
        return ""
    seen = _first_unsafe(way, view, facts.config.min_corridor_radius_m)
    return "" if seen is None else _place(seen)


def _first_unsafe(way: Trajectory, view: Any, radius_m: float) -> Optional[CorridorResult]:
    """Returns where a way is not known to be free; None if it is.

    A vehicle that is too near to something already, because a gust brought it there, is not stopped just there if its
    way leads out within the radius.
    """
    seen = check_corridor(view, way.points, radius_m)
    if not seen.safe and seen.first_unsafe_m < BESIDE_M and way.length_m > radius_m:
        seen = check_corridor(view, way.points_from_arc(radius_m), radius_m)
    return None if seen.safe else seen


def _place(seen: CorridorResult) -> str:
    where = (seen.what_is_unsafe, seen.first_unsafe_m) + tuple(seen.unsafe_point)
    return ("" if seen.fence is not None else "not known free: ") + "%s in %.1f m at (%.1f, %.1f, %.1f)" % where
