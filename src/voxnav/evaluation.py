# SPDX-License-Identifier: BSD-3-Clause
"""Trajectory errors against a reference."""

from __future__ import annotations

import numpy as np

from voxnav.array_types import Array, ArrayLike


class EvaluationError(ValueError):
    """The two trajectories cannot be compared."""


def interpolate_positions(stamps: Array, reference_stamps: Array, reference_positions: Array) -> Array:
    """Interpolates reference positions at the given stamps; NaN rows outside the reference's time span. O(n log m)."""
    out = np.full((len(stamps), 3), np.nan)
    inside = (stamps >= reference_stamps[0]) & (stamps <= reference_stamps[-1])
    for axis in range(3):
        out[inside, axis] = np.interp(stamps[inside], reference_stamps, reference_positions[:, axis])
    return out


def align_se3(source: Array, target: Array) -> tuple[Array, Array]:
    """Returns the rotation R and the translation t that minimise the sum of squares of R source + t - target.

    source, target: (n, 3). Source: Umeyama, Least-squares estimation of transformation parameters between two point
    patterns, PAMI 1991, without scale.
    """
    mean_source, mean_target = source.mean(axis=0), target.mean(axis=0)
    covariance = (target - mean_target).T @ (source - mean_source)
    U, _, Vt = np.linalg.svd(covariance)
    D = np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt)) or 1.0])
    R = U @ D @ Vt
    return R, mean_target - R @ mean_source


def absolute_trajectory_error(stamps: ArrayLike, positions: ArrayLike, reference_stamps: ArrayLike,
                              reference_positions: ArrayLike, align: bool = True) -> float:
    """Returns the RMSE of positions in metres, after SE(3) alignment unless align is False.

    Raises EvaluationError if fewer than three stamps lie within the reference.
    """
    target = interpolate_positions(np.asarray(stamps), np.asarray(reference_stamps), np.asarray(reference_positions))
    valid = np.all(np.isfinite(target), axis=1)
    if valid.sum() < 3:
        raise EvaluationError("only %d of %d poses lie inside the reference's time span" % (valid.sum(), len(valid)))
    source, target = np.asarray(positions)[valid], target[valid]
    if align:
        R, t = align_se3(source, target)
        source = source @ R.T + t
    return float(np.sqrt(np.mean(np.sum((source - target) ** 2, axis=1))))
