# SPDX-License-Identifier: BSD-3-Clause
"""Watches who has the vehicle: what the control manager reports, and whether somebody else has taken it over."""

from dataclasses import replace
from typing import Optional

from voxnav.planning_manager.actions import Means
from voxnav.planning_manager.facts import Facts, Step
from voxnav.planning_manager.inputs import Control
from voxnav.planning_manager.reasons import Because, Reason
from voxnav.planning_manager.states import Idle, Moving, OwnHover, State, flight_of, own_hover

# Diagnostics that are this much newer than the answer to a hover show whether the tracker brakes.
HOVER_SHOWS_S = 0.5
# Within this time the tracker has stopped from any speed.
HOVER_LASTS_S = 10.0
# The tracker may report the end of a trajectory this much before its last point.
TRACKER_STEP_S = 0.3


def watch(state: State, facts: Facts) -> State:
    """Records what the control manager reports: free to fly to the goal, own hover over, trajectory followed."""
    timed = facts.control
    if timed is None:
        return state
    control, stamp_s = timed.value, timed.stamp_s
    stopping = own_hover(state)
    if stopping is not None and not isinstance(state, Moving) and _is_over(stopping, control, stamp_s):
        state = replace(state, hover=None)
    if control.is_free and state.goal is not None and not state.goal.has_been_free:
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
    control = timed.value
    if not control.is_flying:
        return "landed or no longer flown normally"
    if control.is_repelling:
        return None  # the control manager gives the vehicle back by itself
    if not control.accepts_goals and own_hover(state) is None:
        return "somebody else let the vehicle hover or land"
    flight = flight_of(state)
    if flight is None or not flight.is_tracked or control.is_tracking:
        return None
    end_s = min(flight.asked_s, flight.begin_s) + float(flight.trajectory.duration_s)
    is_over = timed.stamp_s > end_s - TRACKER_STEP_S
    return None if is_over or timed.stamp_s < flight.taken_s else "somebody else commands the vehicle"


def drop_goal(what: str) -> Step:
    """Drops the goal without a hover, because somebody else has the vehicle; voxnav waits for a new goal."""
    return Idle(Because(Reason.TAKEN_OVER, "goal dropped: " + what)), ()


def _is_over(stopping: OwnHover, control: Control, stamp_s: float) -> bool:
    """Returns True if the tracker has stopped; an emergency hover lasts until a person allows commands again."""
    if stopping.accepted_s is None or (stopping.means is Means.EHOVER and not control.is_free):
        return False
    return stamp_s > stopping.accepted_s + (HOVER_SHOWS_S if control.is_free else HOVER_LASTS_S)
