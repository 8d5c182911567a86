# SPDX-License-Identifier: BSD-3-Clause
"""Tells which input is missing, old, absurd, or says that the vehicle must not fly."""

from typing import Any, Optional, TypeVar

from voxnav.planning_manager.inputs import Inputs, Timed
from voxnav.planning_manager.owners import who_flies
from voxnav.planning_manager.reasons import Because, Reason

T = TypeVar("T")
# Stamps that are this much newer than now come from another clock, so that their age tells nothing.
FUTURE_S = 1.0


def missing(inputs: Inputs, now_s: float, config: Any) -> Optional[Because]:
    """Tells why the vehicle may not fly now; None if nothing is missing.

    config: voxnav.PlanningManagerConfig
    """
    return (_missing_vehicle(inputs, now_s, config) or _missing_limits(inputs, now_s, config)
            or _missing_map(inputs, now_s, config) or _outside_fences(inputs) or _unplaced_others(inputs))


def _missing_vehicle(inputs: Inputs, now_s: float, config: Any) -> Optional[Because]:
    old = (_missing(inputs.vehicle, Reason.NO_ODOMETRY, "odometry", now_s, config.odometry_timeout_s)
           or _missing(inputs.control, Reason.NO_DIAGNOSTICS, "control manager diagnostics", now_s,
                       config.diagnostics_timeout_s))
    if old is not None or inputs.control is None:
        return old
    others = who_flies(inputs.control.value)
    if others is not None:
        return others
    if not inputs.control.value.accepts_goals:
        return Because(Reason.TRACKER_REFUSES, "tracker does not accept goals")
    return None


def _missing_limits(inputs: Inputs, now_s: float, config: Any) -> Optional[Because]:
    if inputs.limits_problem:
        return Because(Reason.NO_CONSTRAINTS, inputs.limits_problem)
    return (_missing(inputs.limits, Reason.NO_CONSTRAINTS, "constraints", now_s, config.constraints_timeout_s)
            or _missing(inputs.prediction, Reason.NO_PREDICTION, "tracker prediction", now_s,
                        config.tracker_timeout_s))


def _missing_map(inputs: Inputs, now_s: float, config: Any) -> Optional[Because]:
    grid = None if inputs.map_stamp_s is None else Timed(inputs.map_stamp_s, None)
    old = _missing(grid, Reason.NO_MAP, "local map", now_s, config.map_timeout_s)
    if old is not None:
        return old
    frames = inputs.frames
    if frames.differ and frames.map != frames.odometry:
        return Because(Reason.FRAMES_DIFFER, "the local map is in frame %s, the vehicle in %s" % (
            frames.map, frames.odometry))
    if frames.differ:
        return Because(Reason.FRAMES_DIFFER, "the map correction is of frame %s, the vehicle in %s" % (
            frames.correction, frames.odometry))
    timeout_s = config.correction_timeout_s if config.correction_timeout_s > 0.0 else None
    old = _missing(inputs.T_W_O, Reason.NO_CORRECTION, "map correction", now_s, timeout_s)
    if old is not None:
        return old
    return Because(Reason.NODE_LOST, min(inputs.lost_nodes) + " is not running") if inputs.lost_nodes else None


def _outside_fences(inputs: Inputs) -> Optional[Because]:
    if inputs.fencing.problem:
        return Because(Reason.FENCES_UNKNOWN, inputs.fencing.problem)
    placed = inputs.fencing.placed
    if placed is None or inputs.vehicle is None:
        return None
    contact = placed.fences.contact(inputs.vehicle.value.position_O)
    return None if contact is None else Because(Reason.FENCED, "the vehicle is " + placed.what(contact))


def _unplaced_others(inputs: Inputs) -> Optional[Because]:
    return Because(Reason.OTHERS_UNPLACED, inputs.others_problem) if inputs.others_problem else None


def _missing(value: Optional[Timed[T]], reason: Reason, what: str, now_s: float,
             timeout_s: Optional[float]) -> Optional[Because]:
    """Tells what is wrong with one input; None if nothing is. timeout_s: None if its age does not matter."""
    if value is None:
        return Because(reason, "no %s yet" % what)
    # The sentences do not tell the age, which would give a new text on every tick.
    if timeout_s is not None and value.stamp_s < now_s - timeout_s:
        return Because(reason, what + " lost")
    if value.stamp_s > now_s + FUTURE_S:
        return Because(reason, what + " is stamped in the future")
    return None
