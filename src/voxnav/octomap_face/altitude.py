# SPDX-License-Identifier: BSD-3-Clause
"""Moves a saved map up or down so that its ground lies where the vehicle knows the ground to be.

Between two flights the altitude of the map frame changes: it begins where the estimator was started.
"""

import warnings
from typing import Dict, Optional, Sequence, Tuple

import numpy as np

from voxnav._core import LocalMap, LocalMapConfig

# The map is looked through this far above and below the vehicle.
REACH_M = 60.0
# Fewer columns of voxels are no ground.
LEAST_COLUMNS = 3


def ground_height_m(path: str, position_W: Sequence[float], distance_m: float) -> Optional[float]:
    """Returns the height of the ground in an OctoMap around a place; None if none is known there.

    It is the median over the columns of voxels of the lowest surface in each. (The highest surface, which
    mrs_octomap_server takes, is that of a tree above the place.)

    position_W: (3,) in the frame of the map; distance_m: half the side of the square in which the ground is looked for.
    Raises RuntimeError if the file cannot be read.
    """
    side_m = 2.0 * distance_m + 20.0
    config = LocalMapConfig(window_size_m=(side_m, side_m, 2.0 * REACH_M))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # most of the map lies outside of this window
        centers = LocalMap.load_octomap(path, config, tuple(position_W)).occupied_centers(0.5)
    near = centers[np.abs(centers[:, :2] - np.asarray(position_W, dtype=np.float32)[:2]).max(axis=1) <= distance_m]
    lowest: Dict[Tuple[float, float], float] = {}
    for x, y, z in near.tolist():
        lowest[x, y] = min(z, lowest.get((x, y), z))
    return float(np.median(list(lowest.values()))) if len(lowest) >= LEAST_COLUMNS else None


def offset_m(ground_m: float, body_z_m: float, height_m: Optional[float], robot_height_m: float) -> float:
    """Returns by how much a map must rise.

    ground_m: height of its ground; body_z_m: that of the body frame now; height_m: measured height of the body above
    the ground in flight, None on the ground, where the body is robot_height_m above it.
    """
    return body_z_m - (robot_height_m if height_m is None else height_m) - ground_m
