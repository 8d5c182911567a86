# SPDX-License-Identifier: BSD-3-Clause
"""Writes the files of a mapping run: trajectories, metrics, clouds, mesh, maps and the report."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from voxnav import evaluation, files
from voxnav.array_types import Array, ArrayLike
from voxnav.offline.report import write_report
from voxnav.offline.runner import OfflineMapper
from voxnav.plotting import PicturesUnavailable


def write_outputs(mapper: OfflineMapper, directory: str, title: str, safety_distance_m: float, write_mesh: bool,
                  reference: tuple[Array, Array] | None = None) -> dict[str, Any]:
    """Writes all files of a run; returns the metrics.

    reference: (stamps, positions) to measure trajectory errors against, or None.
    """
    os.makedirs(directory, exist_ok=True)
    odometry = np.array(mapper.poses).reshape(-1, 4, 4)
    stamps, optimised = mapper.session.trajectory()
    files.write_tum(os.path.join(directory, "trajectory_odom.txt"), mapper.stamps, odometry)
    files.write_tum(os.path.join(directory, "trajectory.txt"), stamps, optimised)
    with mapper.stages.time("occupied points"):
        occupied = mapper.collection.occupied_points()
    files.write_ply_points(os.path.join(directory, "occupied.ply"), occupied)
    with mapper.stages.time("obstacles"):
        obstacles = mapper.collection.obstacles(safety_distance_m)
    files.write_ply_points(os.path.join(directory, "obstacles.ply"), obstacles)
    if write_mesh:
        with mapper.stages.time("mesh"):
            mapper.collection.save_mesh(os.path.join(directory, "mesh.ply"))
    shift = mapper.map.save_octomap(os.path.join(directory, "map.ot"))
    if shift is not None:
        mapper.warnings.append("map.ot: add %s m to its coordinates to get those of the map" % (shift,))
    with mapper.stages.time("save"):
        mapper.collection.save(os.path.join(directory, "map"))
    counts = dict(mapper.counts, occupied_points=len(occupied), obstacle_voxels=len(obstacles),
                  new_voxels_not_kept=mapper.map.num_new_not_kept,
                  moving_voxels_not_kept=mapper.map.num_moving_not_kept)
    metrics: dict[str, Any] = {"stages": mapper.stages.summary(), "memory": mapper.memory,
                               "warnings": (mapper.left_out.lines() + mapper.warnings + mapper.gaps.notes)[:1000],
                               "counts": counts,
                               "left_out": mapper.left_out.rows(), "left_out_lines": mapper.left_out.lines(),
                               "coverage": _coverage(mapper), "recording": mapper.page,
                               "origin_m": [0.0] * 3 if mapper.origin_m is None else list(mapper.origin_m)}
    if reference is not None:
        metrics["errors"] = _errors(reference, mapper.stamps, odometry, stamps, optimised)
    with open(os.path.join(directory, "metrics.json"), "w") as out:
        json.dump(metrics, out, indent=2, sort_keys=True)
    try:
        write_report(os.path.join(directory, "report.html"), title, metrics, occupied, odometry[:, :3, 3],
                     optimised[:, :3, 3], None if reference is None else _aligned(reference, mapper.stamps, odometry))
    except PicturesUnavailable as error:
        metrics["warnings"].insert(0, "no report.html: %s" % error)
    return metrics


def _coverage(mapper: OfflineMapper) -> dict[str, Any]:
    found = mapper.coverage
    return {"share": found.share, "longest_hole_s": found.longest_hole_s, "is_enough": found.is_enough,
            "sentence": found.sentence()}


def _errors(reference: tuple[Array, Array], stamps: ArrayLike, odometry: Array, optimised_stamps: Array,
            optimised: Array) -> dict[str, float]:
    out = {}
    for name, times, poses in (("odometry", stamps, odometry), ("optimised", optimised_stamps, optimised)):
        try:
            out["ate_%s_m" % name] = evaluation.absolute_trajectory_error(
                np.asarray(times), poses[:, :3, 3], reference[0], reference[1])
        except evaluation.EvaluationError:
            continue  # without overlap in time nothing can be measured
    return out


def _aligned(reference: tuple[Array, Array], stamps: ArrayLike, odometry: Array) -> Array | None:
    """Returns the reference in the frame of the run, for the picture."""
    target = evaluation.interpolate_positions(np.asarray(stamps), reference[0], reference[1])
    valid = np.all(np.isfinite(target), axis=1)
    if valid.sum() < 3:
        return None
    R, t = evaluation.align_se3(target[valid], odometry[valid, :3, 3])
    aligned: Array = target[valid] @ R.T + t
    return aligned
