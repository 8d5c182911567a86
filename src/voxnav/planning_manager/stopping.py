# SPDX-License-Identifier: BSD-3-Clause
"""Transitions that end or forget a flight: hover, takeover, losses, giving up, a new goal, a command to stop."""

from dataclasses import replace
from typing import Optional

from voxnav.planning_manager.actions import Hover
from voxnav.planning_manager.facts import Facts, Step
from voxnav.planning_manager.reasons import Because, Reason
from voxnav.planning_manager.states import Active, Flight, Goal, Idle, Moving, OwnHover, Planning, Publishing, State

HOVER_RETRY_S = 1.0
# Diagnostics that are this much newer than the answer to a hover show whether the tracker brakes.
HOVER_SHOWS_S = 0.5
# Within this time the tracker has stopped from any speed.
HOVER_LASTS_S = 10.0
# The tracker may report the end of a trajectory this much before its last point.
TRACKER_STEP_S = 0.3


def own_hover(state: State) -> Optional[OwnHover]:
    return None if isinstance(state, Moving) else state.hover


def flight_of(state: State) -> Optional[Flight]:
    return None if isinstance(state, Idle) else state.flight


def is_in_motion(state: State) -> bool:
    """Returns True if a trajectory is flown, or may have been accepted by now."""
    return not isinstance(state, Idle) and (state.flight is not None or isinstance(state.job, Publishing))


def brake(state: Active, because: Because, facts: Facts) -> Step:
    """Stops now, and plans again from where the vehicle comes to rest."""
    stopping = OwnHover(because, facts.now_s)
    braking = Planning(because, state.goal, facts.now_s, progress=state.progress, hover=stopping)
    return braking, (Hover(because),)


def accept_goal(state: State, goal: Goal, facts: Facts) -> Step:
    """Replaces the goal; the present flight continues until there is a path to the new goal."""
    because = Because(Reason.NEW_GOAL, "new goal")
    flight = flight_of(state)
    if flight is not None:
        flight = replace(flight, leads=replace(flight.leads, is_to_goal=False, left_m=None))
    # A trajectory that is on its way to the tracker will be flown, although it leads to the old goal.
    job = None if isinstance(state, Idle) or not isinstance(state.job, Publishing) else state.job
    if job is not None:
        job = replace(job, leads=replace(job.leads, is_to_goal=False, left_m=None))
    return Planning(because, goal, facts.now_s, job, flight, hover=own_hover(state)), ()


def stop(because: Because, facts: Facts) -> Step:
    """Drops the goal and hovers, because it was commanded or the goal cannot be reached."""
    return Idle(because, None, OwnHover(because, facts.now_s)), (Hover(because),)


def jump_frame(state: State, because: Because, facts: Facts) -> Step:
    """Handles a jump of the odometry frame: all plans and trajectories are invalid."""
    if isinstance(state, Idle):
        return state, ()
    later_s = facts.now_s + facts.config.retry_interval_s
    if is_in_motion(state):
        braking, actions = brake(state, because, facts)
        return replace(braking, plan_from_s=later_s), actions
    return replace(state, job=None, plan_from_s=later_s), ()


def lose(state: State, missing: Because, facts: Facts) -> Step:
    """Hovers, keeps the goal and waits, because something that a flight needs is missing."""
    stopping = own_hover(state)
    if missing.reason is Reason.TRACKER_REFUSES and stopping is not None:
        return state, ()  # the tracker brakes because voxnav asked for a hover, whose reason stands already
    if is_in_motion(state):
        return Idle(missing.with_prefix("hover: "), state.goal, OwnHover(missing, facts.now_s)), (Hover(missing),)
    if state.goal is None:
        return state, ()
    prefix = "hover: " if facts.inputs.is_in_air else "waiting: "
    return Idle(missing.with_prefix(prefix), state.goal, stopping), ()


def jump_clock(state: State, facts: Facts) -> Step:
    """Handles a clock that jumped back: all recorded times are meaningless."""
    stopping = own_hover(state)
    if stopping is not None and not isinstance(state, Moving):
        accepted_s = None if stopping.accepted_s is None else facts.now_s
        state = replace(state, hover=OwnHover(stopping.because, facts.now_s, accepted_s))
    return lose(state, Because(Reason.CLOCK_JUMPED, "clock jumped back"), facts)


def watch(state: State, facts: Facts) -> State:
    """Records what the control manager reports: free to fly to the goal, own hover over, trajectory followed."""
    timed = facts.control
    if timed is None:
        return state
    control, stamp_s = timed.value, timed.stamp_s
    stopping = own_hover(state)
    if stopping is not None and stopping.accepted_s is not None:
        shown_s = stopping.accepted_s + (HOVER_SHOWS_S if control.is_free else HOVER_LASTS_S)
        if stamp_s > shown_s and not isinstance(state, Moving):
            state = replace(state, hover=None)
    if control.is_free and state.goal is not None and not state.goal.has_been_free:
        state = replace(state, goal=replace(state.goal, has_been_free=True))
    flight = flight_of(state)
    if flight is not None and control.is_tracking and not flight.is_tracked and stamp_s >= flight.begin_s:
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
    if not control.accepts_goals and own_hover(state) is None:
        return "somebody else let the vehicle hover or land"
    flight = flight_of(state)
    if flight is None or not flight.is_tracked or control.is_tracking:
        return None
    is_over = timed.stamp_s > flight.asked_s + float(flight.trajectory.duration_s) - TRACKER_STEP_S
    return None if is_over or timed.stamp_s < flight.begin_s else "somebody else commands the vehicle"


def drop_goal(what: str) -> Step:
    """Drops the goal without a hover, because somebody else has the vehicle; voxnav waits for a new goal."""
    return Idle(Because(Reason.TAKEN_OVER, "goal dropped: " + what)), ()


def repeat_hover(state: State, facts: Facts) -> Optional[Step]:
    """Asks again for a hover that is not accepted yet; nothing else is done meanwhile. None if there is none."""
    stopping = own_hover(state)
    if stopping is None or stopping.accepted_s is not None or isinstance(state, Moving):
        return None
    if facts.now_s - stopping.sent_s <= HOVER_RETRY_S:
        return state, ()
    again = replace(state, hover=replace(stopping, sent_s=facts.now_s))
    return again, (Hover(stopping.because, is_repeat=True),)


def hover_answered(state: State, problem: str, facts: Facts) -> Step:
    stopping = own_hover(state)
    if stopping is None or isinstance(state, Moving):
        return state, ()
    if problem:
        because = Because(stopping.because.reason, "%s; hover fails: %s" % (stopping.because.sentence, problem))
        return replace(state, because=because, hover=replace(stopping, sent_s=facts.now_s)), ()
    return replace(state, hover=replace(stopping, accepted_s=facts.now_s)), ()
