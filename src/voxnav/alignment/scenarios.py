# SPDX-License-Identifier: BSD-3-Clause
"""Worlds and paths of the evaluation. Everything follows from the scenario's name and the seed.

Frame W: z up, metres. A path is (n, 4): x, y, z, yaw, one row per scan.
"""

from __future__ import annotations

import collections
from typing import TYPE_CHECKING, Any, NamedTuple, Union

import numpy as np

from voxnav.array_types import Array

if TYPE_CHECKING:
    from voxnav.alignment.corridor import Corridor
    from voxnav.simulation import World  # needs Embree

    AnyWorld = Union[World, Corridor]


class Scenario(NamedTuple):
    """A world and the path that is flown in it.

    world: fields of WorldConfig (or the path of a YAML file), or None for the corridor. corners: (k, 2) corners of the
    path, in order. drift_m: largest distance between estimated and true position without trend_m. trend_m: further
    drift, which grows evenly to this value at the end of the flight.
    """

    name: str
    about: str
    world: dict[str, Any] | str | None
    corners: Array
    height_m: float = 2.5
    speed_mps: float = 1.0
    drift_m: float = 1.8
    scan_hz: float = 5.0
    hover_s: float = 0.0
    trend_m: tuple[float, float, float] = (0.0, 0.0, 0.0)


_FOREST: dict[str, Any] = {"min_corner_m": [-40.0, -40.0], "size_m": [190.0, 120.0],
                           "leaves_per_tree": 60, "num_houses": 0}
_BARE = dict(_FOREST, trees_per_ha=0.0, bushes_per_ha=0.0, rocks_per_ha=0.0, num_poles=0, num_walls=0)
_LONG = dict(_FOREST, size_m=[230.0, 180.0])
_GROVE = dict(_FOREST, min_corner_m=[-15.0, -25.0], size_m=[70.0, 50.0], goal_m=[45.0, 0.0],
              terrain_margin_m=120.0)


def _rounds(width: float, depth: float, count: int) -> Array:
    ring = [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)]
    return np.array(ring * count + [(0.0, 0.0)])


def _mower(width: float, spacing: float, lines: int) -> Array:
    """Returns waypoints of lines up and down a field, and of the way back along its side."""
    corners = []
    for k in range(lines):
        xs = (0.0, width) if k % 2 == 0 else (width, 0.0)
        corners += [(x, k * spacing) for x in xs]
    return np.array(corners + [(0.0, (lines - 1) * spacing), (0.0, 0.0)])


SCENARIOS = collections.OrderedDict((s.name, s) for s in (
    Scenario("loop", "300 m loop through a forest, 5 minutes", _FOREST, _rounds(110.0, 40.0, 1)),
    Scenario("line", "250 m straight through a forest at 2.5 m/s, no revisit", dict(_FOREST, size_m=[330.0, 80.0]),
             np.array([(0.0, 0.0), (250.0, 0.0)]), speed_mps=2.5),
    Scenario("meadow", "160 m loop over bare ground", _BARE, _rounds(50.0, 30.0, 1)),
    Scenario("corridor", "out and back in an endless corridor, 2 x 60 m", None,
             np.array([(0.0, 0.0), (60.0, 0.0), (0.0, 0.0)]), height_m=1.5),
    Scenario("hover", "2 minutes above one place in a forest", _FOREST, np.array([(0.0, 0.0)]), hover_s=120.0),
    Scenario("revisit", "a grove, a meadow, and the grove again the other way",
             _GROVE, np.array([(0.0, 0.0), (130.0, 0.0), (130.0, 70.0), (75.0, 70.0), (75.0, 4.0), (0.0, 4.0)]),
             speed_mps=2.0, drift_m=1.0, trend_m=(8.0, -6.0, 0.5)),
    Scenario("long", "19 minutes, 1.28 km up and down a forest", _LONG, _mower(140.0, 25.0, 7)[:-1],
             speed_mps=1.122),
))


def at_rate(scenario: Scenario, scan_hz: float | None) -> Scenario:
    """Returns a scenario with another rate of scans; None leaves its own."""
    return scenario if scan_hz is None else scenario._replace(scan_hz=scan_hz)


def _resampled(corners: Array, step_m: float) -> Array:
    lengths = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))]
    at = np.linspace(0.0, lengths[-1], max(2, int(round(lengths[-1] / step_m)) + 1))
    return np.stack([np.interp(at, lengths, corners[:, k]) for k in range(2)], axis=1)


def _around_obstacles(xy: Array, world: AnyWorld, height_m: float) -> Array:
    """Moves points away from obstacles that are nearer than a safe distance, and keeps the line through them smooth."""
    clear_m, reach_m = 1.2, 0.1
    for _ in range(60):
        p = np.column_stack([xy, world.ground_height(xy[:, 0], xy[:, 1]) + height_m])
        slope = np.stack([world.clearance(p + d) - world.clearance(p - d)
                          for d in reach_m * np.eye(3)[:2]], axis=1) / (2.0 * reach_m)
        push = np.clip(clear_m - world.clearance(p), 0.0, None)[:, None] * slope
        moved = xy + 0.5 * push
        moved[1:-1] = 0.25 * moved[:-2] + 0.5 * moved[1:-1] + 0.25 * moved[2:]
        moved[[0, -1]] = xy[[0, -1]]
        xy = moved
    return xy


def path_of(scenario: Scenario, world: AnyWorld) -> Array:
    """Returns the path of a scenario, (n, 4) x, y, z, yaw with one row for each scan."""
    if scenario.hover_s:
        n = int(scenario.hover_s * scenario.scan_hz)
        turn = 0.3 * np.sin(np.arange(n) * 0.02)
        xy = np.tile(scenario.corners[0], (n, 1))
        return np.column_stack([xy, np.full(n, world.ground_height(*xy[0]) + scenario.height_m), turn])
    xy = _around_obstacles(_resampled(scenario.corners, 0.5), world, scenario.height_m)
    xy = _resampled(xy, scenario.speed_mps / scenario.scan_hz)
    along = np.diff(xy, axis=0)
    yaw = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    kernel = np.ones(15) / 15.0
    yaw = np.convolve(np.pad(np.r_[yaw, yaw[-1]], 7, mode="edge"), kernel, mode="valid")
    z = world.ground_height(xy[:, 0], xy[:, 1]) + scenario.height_m
    return np.column_stack([xy, np.convolve(np.pad(z, 7, mode="edge"), kernel, mode="valid"), yaw])
