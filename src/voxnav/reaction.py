# SPDX-License-Identifier: BSD-3-Clause
"""``scripts/evaluate_reaction``: how soon a flight brakes for a truck that appears before it, and where it rests.

A vehicle flies straight ahead in a large hall, at a constant speed. Right after a sweep a truck stands across its way.
Every sweep goes through the local map and the map of the planner into the check of what is flown, as in flight; the
vehicle obeys exactly and at once, so that what is measured is the time until it is known that it has to stop.
"""

from __future__ import annotations

import argparse
import itertools
from typing import Any, NamedTuple, Sequence

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.planning_manager import Because, Hover, Moving, Publish, Reason
from voxnav.planning_manager.checking import check
from voxnav.planning_manager.facts import Facts
from voxnav.planning_manager.inputs import Inputs, Timed, Vehicle
from voxnav.planning_manager.states import Flight, Goal, Leads

GAPS_M, SPEEDS_MPS = (8.0, 7.0, 6.0, 5.0, 4.0, 3.0), (2.0, 3.0, 4.0, 5.0, 6.0)
SWEEP_S, WARM_UP_S, LONGEST_S = 0.1, 1.5, 6.0
ACCELERATION_MPS2 = 2.0
HALL = (np.array([-20.0, -12.0, -1.8]), np.array([70.0, 12.0, 7.0]))  # lowest and highest corner, the flight is at zero
TRUCK_M = np.array([2.5, 8.5, 2.5])  # along the flight, across, up
WHEELS_M = 0.7  # so far above the ground the truck begins; nothing that the map knows already is beside it
FARTHEST_M = 19.0  # the flight would rest this far from where the truck appears, which is known to be free
NOISE_M = 0.02


class Outcome(NamedTuple):
    """What became of one flight. sweeps: that showed the truck until the vehicle was stopped, None if it never was;
    clearance_m: least distance of the vehicle's middle from the truck; best_m: that of a vehicle that brakes as hard
    as it may at the first sweep; both are negative by the way that is missing, where the truck is hit."""

    gap_m: float
    speed_mps: float
    sweeps: int | None
    clearance_m: float
    best_m: float


def _beams() -> Array:
    """Returns (n, 3) unit directions of a sensor with 64 rows and 90 degrees from lowest to highest."""
    azimuth, elevation = np.meshgrid(2.0 * np.pi * np.arange(1024) / 1024, np.radians(np.linspace(-45.0, 45.0, 64)))
    axes = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    beams: Array = np.stack(axes, axis=-1).reshape(-1, 3)
    return beams


def _ranges(beams: Array, origin: Array, truck: tuple[Array, Array] | None) -> Array:
    """Returns (n,) distances to the walls of the hall or to the truck."""
    with np.errstate(divide="ignore"):
        ranges: Array = np.maximum((HALL[0] - origin) / beams, (HALL[1] - origin) / beams).min(axis=1)
        if truck is None:
            return ranges
        low, high = (truck[0] - origin) / beams, (truck[1] - origin) / beams
    enters, leaves = np.minimum(low, high).max(axis=1), np.maximum(low, high).min(axis=1)
    is_hit = (enters < leaves) & (enters > 0.0)
    ranges[is_hit] = np.minimum(ranges, enters)[is_hit]
    return ranges


class _Flown:
    """The way of the vehicle along x: a speed, and from some time on the way on which it was stopped."""

    def __init__(self, speed_mps: float) -> None:
        self.speed_mps = speed_mps
        self.begin_s, self.begin_m = 0.0, 0.0
        self.way: voxnav.Trajectory | None = None

    def x(self, time_s: float) -> float:
        after_s = time_s - self.begin_s
        if self.way is None:
            return self.begin_m + self.speed_mps * after_s
        place = min(after_s / self.way.dt_s, len(self.way.points) - 1.0)
        return float(np.interp(place, np.arange(len(self.way.points)), self.way.points[:, 0]))

    def speed(self, time_s: float) -> float:
        return (self.x(time_s + 0.01) - self.x(time_s)) / 0.01

    def obey(self, action: Any, time_s: float) -> None:
        if isinstance(action, Publish) or action.trajectory is not None:
            self.way = action.trajectory
        else:
            speed, now_m = self.speed(time_s), self.x(time_s)
            times = np.arange(0.0, speed / ACCELERATION_MPS2 + SWEEP_S, SWEEP_S)
            until = np.minimum(times, speed / ACCELERATION_MPS2)
            line = np.zeros((len(times), 3))
            line[:, 0] = now_m + speed * until - 0.5 * ACCELERATION_MPS2 * until ** 2
            self.way = voxnav.Trajectory(line, SWEEP_S)
        self.begin_s = time_s


def _trajectory(speed_mps: float) -> voxnav.Trajectory:
    """Returns a straight flight from x = 0 that brakes at last, within what is known when the truck appears."""
    cruise_m = speed_mps * WARM_UP_S + max(0.0, FARTHEST_M - speed_mps ** 2 / ACCELERATION_MPS2)
    times = np.arange(0.0, cruise_m / speed_mps, SWEEP_S)
    braking = np.arange(0.0, speed_mps / (0.5 * ACCELERATION_MPS2), SWEEP_S)
    end_m = speed_mps * times[-1]
    x = np.concatenate([speed_mps * times, end_m + (speed_mps * braking - 0.25 * ACCELERATION_MPS2 * braking ** 2)[1:]])
    return voxnav.Trajectory(np.column_stack([x, np.zeros((len(x), 2))]), SWEEP_S)


class _Planner:
    """The check of a flight along x, fed as the nodes feed it."""

    def __init__(self, config: voxnav.NavigationMapConfig, trajectory: voxnav.Trajectory) -> None:
        self.map = voxnav.NavigationMap(config)
        self.map.set_T_W_O(np.eye(4))
        self.local_map = voxnav.LocalMap()
        self.things = voxnav.MovingThings()
        self.sequence = 0
        leads = Leads(0.7, True, None)
        goal = Goal(np.array([100.0, 0.0, 0.0]), None)
        flight = Flight(trajectory, 0.0, leads, goal.position_W, 0.0, 0.0)
        self.state: Any = Moving(Because(Reason.MOVING, "moves"), goal, flight, 1e9)
        self.config = voxnav.PlanningManagerConfig(deceleration_ratio=1.0)

    def sweep(self, points_L: Array, position: Array, time_s: float) -> None:
        T_W_L = np.eye(4)
        T_W_L[:3, 3] = position
        since = self.local_map.sequence
        self.local_map.insert(points_L, T_W_L)
        self.things.update(self.local_map, time_s, position)
        self.local_map.mark_free(position, 0.8)
        resolution_m = self.local_map.config.resolution_m
        is_snapshot, blocks, states, removed = self.local_map.changes_since(since)
        self.sequence += 1
        self.map.set_vehicle(position)
        points, returns, after = self.local_map.new_hits()
        voxels = np.floor(points[after == 1] / resolution_m).astype(np.int32)
        self.map.set_sightings(time_s, resolution_m, np.ascontiguousarray(voxels), returns[after == 1],
                               np.zeros((0, 12)))
        self.map.apply_local(self.sequence, resolution_m, blocks, states.tobytes(), removed, is_snapshot)

    def check(self, position: Array, velocity: Array, time_s: float) -> Sequence[Any]:
        a = ACCELERATION_MPS2
        inputs = Inputs(Timed(time_s, Vehicle(position, velocity)), limits=Timed(time_s, (8.0, a, 4.0, a, 4.0, a)))
        facts = Facts(time_s, inputs, self.config, 1, self.map.view)
        self.state, actions = check(self.state, facts)
        return actions


def fly(gap_m: float, speed_mps: float, use_new_hits: bool = True) -> Outcome:
    """Flies once. The truck appears right after the sweep at WARM_UP_S, gap_m before the vehicle."""
    random, beams = np.random.RandomState(1), _beams()
    map_config = voxnav.NavigationMapConfig(min_altitude_m=-5.0, use_new_hits=use_new_hits)
    flown, planner = _Flown(speed_mps), _Planner(map_config, _trajectory(speed_mps))
    near_m = speed_mps * WARM_UP_S + gap_m
    low = np.array([near_m, -0.5 * TRUCK_M[1], HALL[0][2] + WHEELS_M])
    truck = (low, low + TRUCK_M)
    reacted: int | None = None
    num_warm = int(round(WARM_UP_S / SWEEP_S))
    for i in range(num_warm + int(LONGEST_S / SWEEP_S)):
        time_s = i * SWEEP_S
        position = np.array([flown.x(time_s), 0.0, 0.0])
        if position[0] >= near_m:
            break
        ranges = _ranges(beams, position, truck if i > num_warm else None)
        points = beams * (ranges + random.normal(0.0, NOISE_M, len(ranges)))[:, None]
        planner.sweep(points.astype(np.float32), position, time_s)
        if i < num_warm - 1 or reacted is not None:
            continue  # the hall is not known far enough before; afterwards the stop is flown
        actions = planner.check(position, np.array([flown.speed(time_s), 0.0, 0.0]), time_s)
        stops = [action for action in actions if isinstance(action, (Hover, Publish))]
        if stops and i <= num_warm:
            raise ValueError("the flight is stopped before the truck appears: " + stops[0].because.sentence)
        if stops:
            reacted = i - num_warm
            flown.obey(stops[0], time_s)
    last_m = max(flown.x(i * 0.01) for i in range(int(100 * (WARM_UP_S + LONGEST_S))))
    best_m = gap_m - SWEEP_S * speed_mps - speed_mps ** 2 / (2.0 * ACCELERATION_MPS2)
    return Outcome(gap_m, speed_mps, reacted, near_m - last_m, best_m)


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="evaluate_reaction", description=__doc__)
    parser.add_argument("--gaps", nargs="+", type=float, default=list(GAPS_M), help="[m], default %(default)s")
    parser.add_argument("--speeds", nargs="+", type=float, default=list(SPEEDS_MPS), help="[m/s], default %(default)s")
    parser.add_argument("--no-new-hits", action="store_true", help="wait until the map believes what is seen")
    args = parser.parse_args(argv)
    print("| gap [m] | speed [m/s] | sweeps | clearance [m] | at best [m] |\n|---|---|---|---|---|")
    for gap_m, speed_mps in itertools.product(args.gaps, args.speeds):
        row = fly(gap_m, speed_mps, not args.no_new_hits)
        sweeps = "-" if row.sweeps is None else "%d" % row.sweeps
        print("| %.1f | %.1f | %s | %.2f | %.2f |" % (row.gap_m, row.speed_mps, sweeps, row.clearance_m, row.best_m),
              flush=True)
    return 0
