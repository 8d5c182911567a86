# SPDX-License-Identifier: BSD-3-Clause
"""Compares a solved flight with the truth."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import voxnav
from voxnav.alignment.flight import SimulatedFlight
from voxnav.array_types import Array
from voxnav.evaluation import align_se3
from voxnav.optimizer_session import OptimizerSession

if TYPE_CHECKING:
    from voxnav.alignment.scenarios import AnyWorld


class Errors(NamedTuple):
    """Errors of a trajectory. rmse_m, and axis_m (3,) by axis: after SE(3) alignment; unaligned_m: RMSE with the first
    poses put together; closure_m: error of the way from the first to the last pose."""

    rmse_m: float
    axis_m: Array
    unaligned_m: float
    closure_m: float


class Solved(NamedTuple):
    """A flight after its last solve. stamps_s: (n,); T_W_B and T_true: (n, 4, 4). worst_excess_m: the most, over all
    solves, by which the RMSE of the trajectory up to then exceeded that of its input; not positive when no solve made
    it worse."""

    stamps_s: Array
    T_W_B: Array
    T_true: Array
    before: Errors
    after: Errors
    session: OptimizerSession
    reports: list[voxnav.OptimizeReport]
    worst_excess_m: float


def errors_of(T_est: Array, T_true: Array) -> Errors:
    """Computes the errors of (n, 4, 4) poses against true poses of the same times."""
    p, q = T_est[:, :3, 3], T_true[:, :3, 3]
    R, t = align_se3(p, q)
    left = p @ R.T + t - q
    rooted = (T_true[0] @ np.linalg.inv(T_est[0]) @ T_est)[:, :3, 3]
    return Errors(float(np.sqrt(np.mean(np.sum(left ** 2, axis=1)))), np.sqrt(np.mean(left ** 2, axis=0)),
                  float(np.sqrt(np.mean(np.sum((rooted - q) ** 2, axis=1)))),
                  float(np.linalg.norm(rooted[-1] - q[-1])))


def solve(flight: SimulatedFlight, graph_config: voxnav.SubmapGraphConfig | None = None,
          optimizer_config: voxnav.OptimizerConfig | None = None) -> Solved:
    """Adds the submaps to an optimiser session one after another and solves after each one, as in flight."""
    session, reports, worst_m = OptimizerSession(graph_config, optimizer_config), [], -np.inf
    for record, submap in flight.submaps:
        session.add_submap(record, submap.registration_field(record.stamps_s, record.T_S_B))
        reports.append(session.optimize())
        stamps, poses = session.trajectory()
        rows = np.searchsorted(flight.stamps_s, stamps - 1e-6)
        before, after = errors_of(flight.T_O_B[rows], flight.T_W_B[rows]), errors_of(poses, flight.T_W_B[rows])
        worst_m = max(worst_m, after.rmse_m - before.rmse_m)
    return Solved(stamps, poses, flight.T_W_B[rows], before, after, session, reports, worst_m)


def merged_surface(flight: SimulatedFlight, T_W_S_by_id: dict[int, Array], bends: dict[int, Array]) -> Array:
    """Returns (n, 3) surface points of the merged map in frame W, as users of the map see it."""
    collection = voxnav.SubmapCollection()
    for record, submap in flight.submaps:
        collection.add(record.id, submap, T_W_S_by_id[record.id], record.end_s, bends.get(record.id))
    return collection.occupied_points().astype(np.float64)


def own_surface(flight: SimulatedFlight, T_W_S_by_id: dict[int, Array], bends: dict[int, Array]) -> Array:
    """Returns (n, 3) surface points in frame W that the submaps observed, which move with the poses of the submaps."""
    parts = []
    for record, submap in flight.submaps:
        T = T_W_S_by_id[record.id]
        points = submap.registration_field().bent_surface_points(bends.get(record.id)).astype(np.float64)
        parts.append(points @ T[:3, :3].T + T[:3, 3])
    return np.concatenate(parts)


def aligned_surface(points: Array, T_est: Array, T_true: Array) -> Array:
    """Returns (n, 3) points moved by the SE(3) alignment of the estimated trajectory to the true one."""
    R, t = align_se3(T_est[:, :3, 3], T_true[:, :3, 3])
    return points @ R.T + t


def surface_share(points: Array, world: AnyWorld, within_m: float, limit: int = 40000) -> float:
    """Returns the share of (n, 3) points that lie within a distance of the true surface."""
    distance = world.surface_distance(points[::max(1, len(points) // limit)], 5.0)
    return float(np.mean(distance <= within_m))
