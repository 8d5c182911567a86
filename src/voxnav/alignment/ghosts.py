# SPDX-License-Identifier: BSD-3-Clause
"""``scripts/evaluate_ghosts``: whether the merged map loses a fire truck that drove away, and nothing else. The flight
makes two rounds about a yard, with drift, and the truck moves between them."""

from __future__ import annotations

import argparse
import os
from typing import Any, Iterable, Sequence

import numpy as np
from scipy.spatial import cKDTree

import voxnav
from voxnav.alignment.flight import fly, world_of
from voxnav.alignment.measure import aligned_surface, solve
from voxnav.alignment.pictures import draw_places
from voxnav.alignment.scenarios import Scenario, at_rate
from voxnav.array_types import Array
from voxnav.optimizer_session import SubmapRecord
from voxnav.plotting import require_pictures

_RING = [(2.0, -13.0), (37.0, -13.0), (37.0, 13.0), (2.0, 13.0)]
_NEW_PLACE = (30.0, 2.0, 1.2)  # x, y, heading
_HALF_TRUCK_M = np.array([4.3, 1.5])
_LOST_M = 0.5  # a surface is lost if no surface of the later map lies within this distance


def scenario_of(drift_m: float) -> Scenario:
    return Scenario("ghosts", "two rounds about a fire truck", "worlds/firetruck.yaml",
                    np.array([(0.0, 0.0)] + 2 * _RING + [(0.0, 0.0)]), speed_mps=1.5, drift_m=drift_m)


def _is_truck(points: Array, T_W_V: Array, margin_m: float, lowest_m: float) -> Array:
    p = (points - T_W_V[:3, 3]) @ T_W_V[:3, :3]
    inside = np.all(np.abs(p[:, :2]) < _HALF_TRUCK_M + margin_m, axis=1)
    is_truck: Array = inside & (p[:, 2] > lowest_m) & (p[:, 2] < 4.0)
    return is_truck


def _corners(T_W_V: Array) -> Array:
    x, y = _HALF_TRUCK_M
    corners: Array = np.array([(-x, -y), (x, -y), (x, y), (-x, y)]) @ T_W_V[:2, :2].T + T_W_V[:2, 3]
    return corners


def _map_of(submaps: Iterable[tuple[SubmapRecord, voxnav.Submap]], T_W_S_by_id: dict[int, Array],
            bends: dict[int, Array]) -> tuple[voxnav.SubmapCollection, Array]:
    collection = voxnav.SubmapCollection()
    for record, submap in submaps:
        collection.add(record.id, submap, T_W_S_by_id[record.id], record.end_s, bends.get(record.id))
    return collection, collection.occupied_points().astype(np.float64)


def _changes(collection: voxnav.SubmapCollection, T_est: Array, T_true: Array,
             trucks: list[Array]) -> list[tuple[str, int, float]]:
    """Returns the changes that the map lists, as (kind, voxels, metres to the nearest place of the truck)."""
    out = []
    for change in collection.changes(10):
        center = aligned_surface(np.array([change["center"]]), T_est, T_true)[0]
        gap_m = min(float(np.linalg.norm(center[:2] - T[:2, 3])) for T in trucks)
        out.append((change["kind"], change["voxels"], gap_m))
    return out


def evaluate(seed: int, scenario: Scenario, picture: str | None = None) -> list[tuple[Any, ...]]:
    """Flies and solves one scenario. Returns one row for drifting and one for corrected poses: (name, share of the old
    truck that is left, share of static surface that is lost, changes). Draws the corrected map before the truck moved
    and at the end if `picture` names a file."""
    world: Any = world_of(scenario, seed)
    trucks, moved_at_s = [world.vehicle_pose()], []

    def drive(i: int, n: int) -> None:
        if i == n // 2:
            world.move_vehicle(*_NEW_PLACE)
            trucks.append(world.vehicle_pose())
            moved_at_s.append(i / scenario.scan_hz)

    flight = fly(scenario, seed, world, drive)
    solved = solve(flight)
    first = [item for item in flight.submaps if item[0].end_s < moved_at_s[0]]
    rows, true = np.searchsorted(flight.stamps_s, solved.stamps_s - 1e-6), solved.T_true
    out: list[tuple[Any, ...]] = []
    sides: list[tuple[str, dict[int, Array], dict[int, Array], Array, float]] = [
        ("drifting", {r.id: r.T_O_S for r, _ in flight.submaps}, {}, flight.T_O_B[rows], scenario.drift_m),
        ("corrected", solved.session.graph.poses(), solved.session.bends(), solved.T_W_B, 0.0)]
    for name, poses, bends, T_est, slack_m in sides:
        old = aligned_surface(_map_of(first, poses, bends)[1], T_est, true)
        collection, points = _map_of(flight.submaps, poses, bends)
        points = aligned_surface(points, T_est, true)
        truck = _is_truck(old, trucks[0], 0.3, 0.3)
        static = ~(_is_truck(old, trucks[0], 1.5, -1.0) | _is_truck(old, trucks[1], 1.5, -1.0))
        gap_m = cKDTree(points).query(old[static])[0]
        out.append((name, _is_truck(points, trucks[0], 0.3, 0.3).sum() / max(1, truck.sum()),
                    float(np.mean(gap_m > _LOST_M + slack_m)), _changes(collection, T_est, true, trucks)))
        if picture and name == "corrected":
            corners = [_corners(T) for T in trucks]
            draw_places(picture, {"before it drove away": (old, corners[:1]),
                                  "after the second round": (points, corners)}, world)
    return out


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="evaluate_ghosts", description=__doc__)
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3], help="of world, sensor and drift")
    parser.add_argument("--drift", type=float, default=1.0, help="peak [m], default %(default)s")
    parser.add_argument("--scan-hz", type=float, help="scans per second; default: those of the scenario")
    parser.add_argument("--out", default=os.path.join("build", "ghosts"), help="for pictures, default %(default)s")
    args = parser.parse_args(argv)
    require_pictures()
    os.makedirs(args.out, exist_ok=True)
    scenario = at_rate(scenario_of(args.drift), args.scan_hz)
    print("seed  poses      old truck left  static lost  listed where the truck was, is, and elsewhere (voxels)")
    for seed in args.seeds:
        for name, truck, lost, changes in evaluate(seed, scenario, os.path.join(args.out, "truck_%d.png" % seed)):
            at_trucks = ["%s %d" % (kind, voxels) for kind, voxels, gap_m in changes if gap_m < 4.0]
            others = [(kind, voxels) for kind, voxels, gap_m in changes if gap_m >= 4.0]
            elsewhere = ["%s: %d of %d" % (kind, len(rows), sum(rows)) for kind in ("appeared", "disappeared")
                         for rows in [[voxels for k, voxels in others if k == kind]]]
            print("%4d  %-9s %13.1f %% %10.2f %%  %s | %s" % (
                seed, name, 100.0 * truck, 100.0 * lost, ", ".join(at_trucks), ", ".join(elsewhere)), flush=True)
    print("pictures in %s" % args.out)
    return 0
