# SPDX-License-Identifier: BSD-3-Clause
"""Ways on which the vehicle comes to rest, as positions at equal time steps, and how dangerous they are.

Source: uniformly decelerated motion, horizontally and vertically apart, as trackers brake; docs/maths/planning.md.
"""

import math
from typing import Any, Tuple

import numpy as np

from voxnav._core import Trajectory, check_corridor, first_meeting
from voxnav.array_types import Array
from voxnav.planning_manager.facts import Facts
from voxnav.planning_manager.states import Flight

STEP_S = 0.1
MAX_STEPS = 300
# Slower counts as stopped at the end of a way; less than this left of a climb counts as climbed.
CREEP_MPS, CREEP_M = 0.05, 0.002


def braked_m(times_s: Array, speed_mps: float, deceleration_mps2: float, reaction_s: float) -> Array:
    """Returns the distances (n,) moved up to times (n,) after a reaction time at constant speed, then braking."""
    braking_s = np.clip(times_s - reaction_s, 0.0, speed_mps / deceleration_mps2)
    steady_s = np.minimum(times_s, reaction_s)
    return np.asarray(speed_mps * (steady_s + braking_s) - 0.5 * deceleration_mps2 * braking_s ** 2)


def braking_limits(facts: Facts) -> Tuple[float, float]:
    """Returns the horizontal and the vertical deceleration [m/s^2].

    The tighter vertical limit counts both ways, because braking a climb is accelerating downwards.
    """
    limits, ratio = facts.limits, facts.config.deceleration_ratio
    return ratio * limits[1], ratio * min(limits[3], limits[5])


def straight_way(facts: Facts) -> Trajectory:
    """Returns the way on which a hover brakes: straight ahead, after the reaction time."""
    horizontal, vertical = braking_limits(facts)
    reaction_s, velocity = facts.config.reaction_time_s, facts.vehicle.velocity_O
    speed, climb = float(np.hypot(velocity[0], velocity[1])), float(velocity[2])
    times = _times(reaction_s + max(speed / horizontal, abs(climb) / vertical))
    direction = velocity[:2] / max(speed, 1e-9)
    out = np.tile(facts.vehicle.position_O, (len(times), 1))
    out[:, :2] += np.outer(braked_m(times, speed, horizontal, reaction_s), direction)
    out[:, 2] += math.copysign(1.0, climb) * braked_m(times, abs(climb), vertical, reaction_s)
    return Trajectory(out, float(times[1]))


def climbing_way(facts: Facts, height_m: float, reaction_s: float) -> Trajectory:
    """Returns the way on which the vehicle brakes horizontally while it climbs by a height to rest.

    If it climbs so fast that it cannot rest at that height, it climbs as little as it can.
    """
    horizontal, vertical = braking_limits(facts)
    velocity, ascending_mps = facts.vehicle.velocity_O, facts.limits[2]
    speed = float(np.hypot(velocity[0], velocity[1]))
    heights, climb = [0.0], float(velocity[2])
    height_m = max(height_m, max(0.0, climb) * (climb / (2.0 * vertical) + reaction_s + STEP_S))
    while len(heights) < MAX_STEPS and height_m - heights[-1] > CREEP_M:
        if STEP_S * len(heights) > reaction_s:
            change = vertical * STEP_S
            # The speed from which equal changes in each step end at the height: that of continuous braking, in steps.
            to_rest = math.sqrt(0.25 * change ** 2 + 2.0 * vertical * (height_m - heights[-1])) - 0.5 * change
            wanted = min(ascending_mps, to_rest)
            climb += min(max(wanted - climb, -change), change)
        heights.append(min(height_m, heights[-1] + climb * STEP_S))
    times = STEP_S * np.arange(max(len(heights), int((reaction_s + speed / horizontal) / STEP_S) + 2))
    out = np.tile(facts.vehicle.position_O, (len(times), 1))
    out[:, :2] += np.outer(braked_m(times, speed, horizontal, reaction_s), velocity[:2] / max(speed, 1e-9))
    out[:, 2] += np.append(heights, np.full(len(times) - len(heights), heights[-1]))
    return Trajectory(out, STEP_S)


def following_way(facts: Facts, flight: Flight, reaction_s: float) -> Trajectory:
    """Returns the way that brakes along the flown trajectory, never faster than the trajectory itself."""
    line = flight.trajectory.points_from_arc(flight.arc_m(facts.vehicle.position_O, facts.now_s))
    pieces = np.diff(line, axis=0)
    lengths = np.linalg.norm(pieces, axis=1)
    arcs = np.append(0.0, np.cumsum(lengths))
    deceleration = _deceleration_along(pieces[lengths > 1e-6], braking_limits(facts))
    passed, speed = [0.0], facts.vehicle.speed_mps
    while len(passed) < MAX_STEPS and speed > CREEP_MPS and passed[-1] < arcs[-1]:
        if STEP_S * len(passed) > reaction_s:
            speed -= deceleration * STEP_S
        piece = min(int(np.searchsorted(arcs, passed[-1], side="right")) - 1, len(lengths) - 1)
        # The first piece may have been cut short, so its length tells nothing about the speed.
        fastest = lengths[piece] / flight.trajectory.dt_s if piece > 0 else speed
        speed = max(0.0, min(speed, max(fastest, CREEP_MPS)))
        passed.append(min(float(arcs[-1]), passed[-1] + speed * STEP_S))
    return Trajectory(np.column_stack([np.interp(passed, arcs, line[:, k]) for k in range(3)]), STEP_S)


def way_ahead(facts: Facts) -> Trajectory:
    """Returns the way that the vehicle is about to take: to the tracker's prediction and along it.

    Without a prediction the vehicle is taken to brake straight ahead.
    """
    prediction = facts.inputs.prediction
    if prediction is None:
        return straight_way(facts)
    times = np.asarray(prediction.value.times_s)
    is_ahead = times >= facts.now_s
    if np.count_nonzero(is_ahead) < 2:
        return straight_way(facts)
    ahead = prediction.value.positions_O[is_ahead]
    step_s = float(np.mean(np.diff(times[is_ahead])))
    return Trajectory(np.vstack([facts.vehicle.position_O, ahead]), max(step_s, 1e-3))


def danger_of(way: Trajectory, view: Any, radius_m: float, now_s: float) -> Tuple[float, float]:
    """Returns the speeds [m/s] at which the way enters occupied and unknown space; zero where it does not.

    A place where something that moves may be met counts as occupied. view: voxnav.OccupancyView
    """
    meeting = first_meeting(view, way, now_s, radius_m)
    met_mps = 0.0 if meeting is None else _speed_at(way, meeting[0])
    seen = check_corridor(view, way.points, radius_m)
    if seen.safe:
        return met_mps, 0.0
    occupied = check_corridor(view, way.points, radius_m, allow_unknown=True)
    occupied_mps = 0.0 if occupied.safe else _speed_at(way, occupied.first_unsafe_m)
    return max(met_mps, occupied_mps), _speed_at(way, seen.first_unsafe_m)


def _speed_at(way: Trajectory, arc_m: float) -> float:
    lengths = np.linalg.norm(np.diff(way.points, axis=0), axis=1)
    if len(lengths) == 0:
        return CREEP_MPS
    piece = min(int(np.searchsorted(np.cumsum(lengths), arc_m, side="right")), len(lengths) - 1)
    return max(CREEP_MPS, float(lengths[piece]) / way.dt_s)


def _times(until_s: float) -> Array:
    step_s = max(STEP_S, until_s / MAX_STEPS)
    return step_s * np.arange(int(until_s / step_s) + 2)


def _deceleration_along(pieces: Array, limits: Tuple[float, float]) -> float:
    """Returns the deceleration allowed along all pieces (n, 3) of a line: no component exceeds its limit."""
    if len(pieces) == 0:
        return limits[0]
    lengths = np.linalg.norm(pieces, axis=1)
    level, steep = np.hypot(pieces[:, 0], pieces[:, 1]) / lengths, np.abs(pieces[:, 2]) / lengths
    return float(min(limits[0] / max(level.max(), 1e-9), limits[1] / max(steep.max(), 1e-9)))
