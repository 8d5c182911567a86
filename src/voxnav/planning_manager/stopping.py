# SPDX-License-Identifier: BSD-3-Clause
"""Transitions that end or forget a flight: hover, losses, giving up, a new goal, a command to stop."""

from dataclasses import replace
from typing import Optional

from voxnav.planning_manager.actions import Hover, Means
from voxnav.planning_manager.facts import Facts, Step
from voxnav.planning_manager.input_ids import is_own
from voxnav.planning_manager.owners import who_flies
from voxnav.planning_manager.reasons import Because, Reason
from voxnav.planning_manager.states import (Active, Goal, Idle, Leads, Moving, OwnHover, Planning, Publishing,
                                            State, flight_of, own_hover)
from voxnav.planning_manager.stops import stop_for

TOO_LATE = "brake: a trajectory was accepted too late"
# A stop that no means achieves is tried again after this time.
HOVER_RETRY_S = 1.0
# The next stronger means after a refused one.
STRONGER = {Means.FOLLOW: Means.HOVER, Means.CLIMB: Means.HOVER, Means.HOVER: Means.EHOVER}

# Reasons for which voxnav must not command the vehicle at all.
FLOWN_BY_OTHERS = frozenset((Reason.REPELLED, Reason.REMOTE_CONTROL, Reason.LANDING, Reason.NOT_NORMAL))


def is_flown_by_others(facts: Facts) -> bool:
    """Returns True if somebody else flies the vehicle, or nobody does: then it is not told to hover either.

    An emergency hover in particular would take it from the pilot.
    """
    control = facts.control
    return control is not None and who_flies(control.value) is not None


def is_in_motion(state: State) -> bool:
    """Returns True if a trajectory is flown, or may have been accepted by now."""
    return not isinstance(state, Idle) and (state.flight is not None or isinstance(state.job, Publishing))


def brake(state: Active, because: Because, facts: Facts) -> Step:
    """Stops now, and plans again from where the vehicle comes to rest."""
    stopping, hover = stop_for(because, facts.flown(state.flight), facts)
    braking = Planning(hover.because, state.goal, facts.now_s, progress=state.progress, hover=stopping)
    return braking, (hover,)


def accept_goal(state: State, goal: Goal, facts: Facts) -> Step:
    """Replaces the goal; the present flight continues until there is a path to the new goal."""
    because = Because(Reason.NEW_GOAL, "new goal")
    flight = flight_of(state)
    if flight is not None:
        flight = replace(flight, leads=Leads(flight.leads.radius_m, False, None))
    # A trajectory that is on its way to the tracker will be flown, although it leads to the old goal.
    job = None if isinstance(state, Idle) or not isinstance(state.job, Publishing) else state.job
    if job is not None:
        job = replace(job, leads=Leads(job.leads.radius_m, False, None))
    return Planning(because, goal, facts.now_s, job, flight, hover=own_hover(state)), ()


def stop(state: State, because: Because, facts: Facts) -> Step:
    """Drops the goal and hovers, because it was commanded or the goal cannot be reached."""
    stopping, hover = stop_for(because, facts.flown(flight_of(state)), facts)
    return Idle(because, None, stopping), (hover,)


def jump_frame(state: State, because: Because, facts: Facts) -> Step:
    """Handles a jump of the odometry frame: all plans and trajectories are invalid."""
    if isinstance(state, Idle):
        return state, ()
    later_s = facts.now_s + facts.config.retry_interval_s
    if is_in_motion(state):
        braking, actions = brake(state, because, facts.blind())
        return replace(braking, plan_from_s=later_s), actions
    return replace(state, job=None, plan_from_s=later_s), ()


def close_map(state: State, because: Because, facts: Facts) -> Step:
    """Drops a goal whose map was closed, and hovers if the vehicle flies to it."""
    return drop(state, because, facts.blind())


def drop(state: State, because: Because, facts: Facts) -> Step:
    """Drops the goal, and hovers if the vehicle flies to it."""
    if state.goal is None:
        return state, ()
    if is_in_motion(state):
        return stop(state, because, facts)
    return Idle(because, None, own_hover(state)), ()


def lose(state: State, missing: Because, facts: Facts) -> Step:
    """Hovers, keeps the goal and waits, because something that a flight needs is missing."""
    stopping = own_hover(state)
    if missing.reason is Reason.TRACKER_REFUSES and stopping is not None:
        return state, ()  # the tracker brakes because voxnav asked for a hover, whose reason stands already
    if missing.reason in FLOWN_BY_OTHERS:
        # Nothing is commanded: whatever voxnav asked for, it is not what the vehicle does now.
        return (state if state.goal is None else Idle(missing.with_prefix("waiting: "), state.goal)), ()
    if is_in_motion(state):
        stopping, hover = stop_for(missing, facts.flown(flight_of(state)), facts)
        return Idle(missing.with_prefix("hover: "), state.goal, stopping), (hover,)
    if state.goal is None:
        return state, ()
    prefix = "hover: " if facts.inputs.is_in_air else "waiting: "
    return Idle(_with_failure(missing.with_prefix(prefix), stopping), state.goal, stopping), ()


def jump_clock(state: State, facts: Facts) -> Step:
    """Handles a clock that jumped back: all recorded times are meaningless."""
    stopping = own_hover(state)
    if stopping is not None and not isinstance(state, Moving):
        accepted_s = None if stopping.accepted_s is None else facts.now_s
        state = replace(state, hover=OwnHover(stopping.because, facts.now_s, accepted_s))
    return lose(state, Because(Reason.CLOCK_JUMPED, "clock jumped back"), facts)


def repeat_hover(state: State, facts: Facts) -> Optional[Step]:
    """Asks again for a hover that is not accepted yet; nothing else is done meanwhile. None if there is none."""
    stopping = own_hover(state)
    if stopping is None or stopping.accepted_s is not None or isinstance(state, Moving):
        return None
    if facts.now_s - stopping.sent_s <= HOVER_RETRY_S:
        return state, ()
    return _ask_again(state, stopping, Means.HOVER, facts)


def stop_late(state: State, facts: Facts) -> Optional[Step]:
    """Stops a trajectory of voxnav that the tracker took too late, unless somebody else has ended it since.

    Newer diagnostics tell whether it is flown. None if there is nothing to stop, or not yet.
    """
    timed, prediction = facts.control, facts.inputs.prediction
    if not isinstance(state, Idle) or state.late_s is None or timed is None or timed.stamp_s <= state.late_s:
        return None
    state, input_id = replace(state, late_s=None), None if prediction is None else prediction.value.input_id
    is_flown = timed.value.is_free and timed.value.is_tracking and (input_id is None or is_own(input_id))
    if not is_flown:
        return state, ()
    stopping, hover = stop_for(Because(Reason.BRAKE, TOO_LATE), None, facts)
    return replace(state, hover=stopping), (hover,)


def hover_answered(state: State, problem: str, facts: Facts) -> Step:
    """Takes the answer to a hover. If it is refused while the vehicle moves, the next stronger means follows at once.

    Emergency hover is not for a vehicle at rest, because after it a person has to allow commands again.
    """
    stopping = own_hover(state)
    if stopping is None or isinstance(state, Moving):
        return state, ()
    if not problem:
        return replace(state, hover=replace(stopping, accepted_s=facts.now_s)), ()
    stopping = replace(stopping, failed="%s fails: %s" % (stopping.means.value, problem))
    state = replace(state, because=_with_failure(stopping.because, stopping))
    stronger = STRONGER.get(stopping.means)
    is_at_rest = facts.is_vehicle_known and not facts.is_in_motion
    if stronger is None or (stronger is Means.EHOVER and (is_at_rest or is_flown_by_others(facts))):
        return replace(state, hover=replace(stopping, sent_s=facts.now_s)), ()
    return _ask_again(state, stopping, stronger, facts)


def hover_again(state: State, facts: Facts) -> Step:
    """Asks once more for a hover, because the tracker took a trajectory after it."""
    stopping = own_hover(state)
    if stopping is None or isinstance(state, Moving):
        return state, ()
    return _ask_again(state, stopping, Means.HOVER, facts)


def _ask_again(state: State, stopping: OwnHover, means: Means, facts: Facts) -> Step:
    if isinstance(state, Moving):
        return state, ()
    again = replace(stopping, sent_s=facts.now_s, accepted_s=None, means=means)
    return replace(state, hover=again), (Hover(stopping.because, is_repeat=True, means=means),)


def _with_failure(because: Because, stopping: Optional[OwnHover]) -> Because:
    if stopping is None or not stopping.failed:
        return because
    return Because(because.reason, "%s; %s" % (because.sentence, stopping.failed))
