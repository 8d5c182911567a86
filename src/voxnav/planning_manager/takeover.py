# SPDX-License-Identifier: BSD-3-Clause
"""Watches who has the vehicle: what the control manager reports, and whether somebody else has taken it over."""

from dataclasses import replace
from typing import Optional

from voxnav.planning_manager.actions import Means
from voxnav.planning_manager.facts import Facts, Step
from voxnav.planning_manager.input_ids import is_own
from voxnav.planning_manager.inputs import Control, Timed
from voxnav.planning_manager.owners import who_flies
from voxnav.planning_manager.reasons import Because, Reason
from voxnav.planning_manager.states import Flight, Idle, Moving, OwnHover, Publishing, State, flight_of, own_hover

# Diagnostics that are this much newer than the answer to a hover show whether the tracker brakes.
HOVER_SHOWS_S = 0.5
# Within this time the tracker has stopped from any speed.
HOVER_LASTS_S = 10.0
# The tracker may report the end of a trajectory this much before its last point.
TRACKER_STEP_S = 0.3
# Diagnostics and predictions that are this much newer than the tracker's answer to a trajectory show it.
TAKEN_SHOWS_S = 0.5
# A prediction and diagnostics this near in time are about the same command.
FRESH_S = 0.3
# A tracker that is to move horizontally by more than this obeys a reference. Trackers that climb over other UAVs do
# not, nor do those that come to rest within REST_S after a trajectory of voxnav.
REFERENCE_M, REST_S = 1.5, 2.0


def watch(state: State, facts: Facts) -> State:
    """Records what the control manager reports: free to fly to the goal, own hover over, trajectory followed."""
    timed = facts.control
    if timed is None:
        return state
    control, stamp_s = timed.value, timed.stamp_s
    stopping = own_hover(state)
    if stopping is not None and not isinstance(state, Moving) and _is_over(stopping, control, stamp_s):
        state = replace(state, hover=None)
    is_free = control.is_free and foreign_command(state, timed, facts) is None
    if is_free and state.goal is not None and not state.goal.has_been_free:
        state = replace(state, goal=replace(state.goal, has_been_free=True))
    flight = flight_of(state)
    if flight is not None and control.is_tracking and not flight.is_tracked and stamp_s >= flight.taken_s:
        state = replace(state, flight=replace(flight, is_tracked=True))
    return state


def taken_over(state: State, facts: Facts) -> Optional[str]:
    """Tells how somebody else took the vehicle over while it flew for voxnav; None while voxnav has it.

    The control manager takes the callbacks away during any hover; those of voxnav's own come back a little later.
    """
    timed = facts.control
    if timed is None or state.goal is None or not state.goal.has_been_free:
        return None
    control, stopping = timed.value, own_hover(state)
    others = who_flies(control)
    if others is not None and stopping is not None and stopping.means is Means.EHOVER:
        return "after the emergency hover of voxnav a person has to allow commands again"
    if others is not None:
        return "landed" if others.reason is Reason.NOT_FLYING else others.sentence
    if not control.accepts_goals and stopping is None and not _may_be_before(state, timed.stamp_s):
        return "somebody else let the vehicle hover, or took the callbacks of the tracker away"
    return foreign_command(state, timed, facts)


def foreign_command(state: State, timed: Timed[Control], facts: Facts) -> Optional[str]:
    """Tells which command of another node the tracker obeys; None if it obeys none, or voxnav's own.

    A reference of another node ends the trajectory that is tracked; a trajectory of another node has another input_id.
    """
    control, flight = timed.value, flight_of(state)
    if flight is not None and not control.is_tracking and _should_be_tracked(flight, timed.stamp_s):
        return "somebody else commands the vehicle"
    prediction = facts.inputs.prediction
    if prediction is None or _may_be_own(state, prediction.stamp_s) or prediction.stamp_s < timed.stamp_s - FRESH_S:
        return None
    input_id = prediction.value.input_id
    if control.is_tracking:
        if input_id is None or is_own(input_id):
            return None
        return "somebody else flies a trajectory, with the input_id %d" % input_id
    way_m = prediction.value.across_m
    if not control.has_goal or way_m < REFERENCE_M or _has_just_ended(flight, facts.now_s):
        return None
    return "somebody else sends the vehicle to a place %.1f m away" % way_m


def _may_be_before(state: State, stamp_s: float) -> bool:
    """Returns True for diagnostics that may be from before the flown trajectory: then it is voxnav's own hover."""
    flight = flight_of(state)
    return flight is not None and not flight.is_tracked and stamp_s <= flight.taken_s + TAKEN_SHOWS_S


def _should_be_tracked(flight: Flight, stamp_s: float) -> bool:
    """Returns True if diagnostics of this time show a trajectory of voxnav, unless another command has ended it."""
    end_s = min(flight.asked_s, flight.begin_s) + float(flight.trajectory.duration_s)
    is_taken = flight.is_tracked or stamp_s > flight.taken_s + TAKEN_SHOWS_S
    return is_taken and flight.taken_s <= stamp_s <= end_s - TRACKER_STEP_S


def _may_be_own(state: State, stamp_s: float) -> bool:
    """Returns True if what the tracker did at this time may be what voxnav has asked for."""
    if not isinstance(state, Idle) and isinstance(state.job, Publishing):
        return True
    flight, stopping = flight_of(state), own_hover(state)
    if stopping is not None:
        return True
    return flight is not None and stamp_s <= flight.taken_s + TAKEN_SHOWS_S


def _has_just_ended(flight: Optional[Flight], now_s: float) -> bool:
    """Returns True while a trajectory of voxnav is flown, and until its tracker has come to rest."""
    return flight is not None and now_s < flight.begin_s + float(flight.trajectory.duration_s) + REST_S


def drop_goal(what: str) -> Step:
    """Drops the goal without a hover, because somebody else has the vehicle; voxnav waits for a new goal."""
    return Idle(Because(Reason.TAKEN_OVER, "goal dropped: " + what)), ()


def _is_over(stopping: OwnHover, control: Control, stamp_s: float) -> bool:
    """Returns True if the tracker has stopped; an emergency hover lasts until a person allows commands again."""
    if stopping.accepted_s is None or (stopping.means is Means.EHOVER and not control.is_free):
        return False
    return stamp_s > stopping.accepted_s + (HOVER_SHOWS_S if control.is_free else HOVER_LASTS_S)
