# SPDX-License-Identifier: BSD-3-Clause
"""A simulated flight whose pose drifts, cut into submaps."""

from __future__ import annotations

import os
import pickle
from typing import TYPE_CHECKING, Any, Callable, Iterable, NamedTuple

import numpy as np

import voxnav
from voxnav.alignment.corridor import Corridor, CorridorLidar
from voxnav.alignment.scenarios import Scenario, path_of
from voxnav.array_types import Array
from voxnav.optimizer_session import SubmapRecord

if TYPE_CHECKING:
    from voxnav.alignment.scenarios import AnyWorld


class SimulatedFlight(NamedTuple):
    """A simulated flight. stamps_s: (n,) seconds; T_W_B: (n, 4, 4) true poses; T_O_B: (n, 4, 4) poses that drift;
    submaps: each with the record of the poses it was made from."""

    stamps_s: Array
    T_W_B: Array
    T_O_B: Array
    submaps: list[tuple[SubmapRecord, voxnav.Submap]]


def drift_of(scenario: Scenario, num_scans: int, seed: int) -> Array:
    """Errors of the estimated position, (n, 3) metres: a random walk inside a ball, smoothed by three lags of 4 s as
    GNSS receivers do (voxnav_simulation::GnssDrift) and scaled to the peak of the scenario, plus the trend of the
    scenario."""
    random, dt_s, lag_s = np.random.RandomState(1000 + seed), 1.0 / scenario.scan_hz, 4.0
    walk, lags, out = np.zeros(3), np.zeros((3, 3)), np.empty((num_scans, 3))
    for i in range(num_scans):
        walk = walk + 0.1 * np.sqrt(dt_s) * random.randn(3)
        walk *= min(1.0, scenario.drift_m / max(float(np.linalg.norm(walk)), 1e-9))
        source = walk
        for lag in lags:
            lag += dt_s / lag_s * (source - lag)
            source = lag
        out[i] = lags[2]
    peak = float(np.linalg.norm(out, axis=1).max())
    trend = np.linspace(0.0, 1.0, num_scans)[:, None] * np.asarray(scenario.trend_m)
    drift: Array = trend + out * (scenario.drift_m / peak if peak > 0.0 else 0.0)
    return drift


def world_of(scenario: Scenario, seed: int) -> AnyWorld:
    if scenario.world is None:
        return Corridor()
    from voxnav import simulation  # needs Embree
    return simulation.World(scenario.world, seed)


def _scanner(scenario: Scenario, world: Any, seed: int) -> Callable[[Array, int], Array]:
    if scenario.world is None:
        corridor = CorridorLidar(seed)
        return lambda T_W_L, index: corridor.organised(T_W_L)
    from voxnav import simulation
    lidar = simulation.Lidar(model="os0-32", columns=512, seed=seed)
    return lambda T_W_L, index: lidar.scan(world, T_W_L, T_W_L, index).organised


def fly(scenario: Scenario, seed: int, world: AnyWorld | None = None,
        before_scan: Callable[[int, int], None] | None = None) -> SimulatedFlight:
    """Simulates a flight through filter, local map and submaps. Deterministic. before_scan(i, n) is called before scan
    i of n and may change the world."""
    world = world or world_of(scenario, seed)
    path, scan = path_of(scenario, world), _scanner(scenario, world, seed)
    T_W_B = np.array([voxnav.pose_from_yaw(row[:3], row[3]) for row in path])
    T_O_B = T_W_B.copy()
    T_O_B[:, :3, 3] += drift_of(scenario, len(path), seed)
    cloud_filter = voxnav.CloudFilter(voxnav.CloudFilterConfig(ghost_intensity=20.0))
    local_map, scheduler = voxnav.LocalMap(voxnav.LocalMapConfig()), voxnav.SubmapScheduler()
    stamps, submaps = np.arange(len(path)) / scenario.scan_hz, []
    for i, stamp in enumerate(stamps):
        if before_scan:
            before_scan(i, len(stamps))
        points = cloud_filter.apply(scan(T_W_B[i], i)).points
        local_map.insert(np.ascontiguousarray(points[:, :3]), T_O_B[i])
        submaps += _filled(scheduler.add_scan(local_map, float(stamp), T_O_B[i]))
    submaps += _filled(scheduler.finish(local_map))
    return SimulatedFlight(stamps, T_W_B, T_O_B, submaps)


def _filled(handovers: Iterable[voxnav.Handover]) -> list[tuple[SubmapRecord, voxnav.Submap]]:
    # Early content is not handled, since nothing leaves a window of 80 m during one submap of these flights.
    return [(SubmapRecord(h.submap_id, h.pose_stamps[0], h.pose_stamps[-1], h.T_O_S, h.pose_stamps, h.T_S_B),
             voxnav.Submap.from_content(h.content, np.linalg.inv(h.T_O_S))) for h in handovers if h.is_final]


def kept_flight(scenario: Scenario, seed: int, folder: str | None) -> SimulatedFlight:
    """Returns a flight of fly(), kept in a folder between runs. Delete the folder when the mapping pipeline changes."""
    if not folder:
        return fly(scenario, seed)
    path = os.path.join(folder, "%s_%d_%g_hz.pickle" % (scenario.name, seed, scenario.scan_hz))
    if not os.path.exists(path):
        os.makedirs(folder, exist_ok=True)
        flight = fly(scenario, seed)
        with open(path + ".part", "wb") as out:
            rows = [(tuple(record), submap.to_bytes()) for record, submap in flight.submaps]
            pickle.dump((flight.stamps_s, flight.T_W_B, flight.T_O_B, rows), out)
        os.replace(path + ".part", path)
    with open(path, "rb") as source:
        stamps_s, T_W_B, T_O_B, kept = pickle.load(source)
    return SimulatedFlight(stamps_s, T_W_B, T_O_B,
                           [(SubmapRecord(*record), voxnav.Submap.from_bytes(submap)) for record, submap in kept])
