# SPDX-License-Identifier: BSD-3-Clause
"""A flight through a simulated forest, each scan with the surface that its beams were aimed at."""

from __future__ import annotations

from typing import Any, Iterator, NamedTuple

import numpy as np

from voxnav import simulation
from voxnav.array_types import Array

SCAN_HZ, STEP_M, HEIGHT_M = 10.0, 0.3, 2.0  # 3 m/s, between the trunks
# An OS0 as it is: a beam of 0.35 degrees, whose returns mix where surfaces follow each other closely.
WIDE_BEAM: dict[str, Any] = {"footprint_rays": 12}
GENUINE = 16  # labels below are surface classes


class AimedScan(NamedTuple):
    """organised: (h, w, 4) as the cloud filter reads it; labels: (h, w); surface_W: (n, 3) where the axes of beams meet
    surfaces, without any error, and their classes (n,)."""

    T_W_L: Array
    organised: Array
    labels: Array
    surface_W: Array
    classes: Array

    def points_L(self) -> Array:
        """Returns (n, 3) float32 returns without those of the UAV itself and of ghosts, as a perfect filter would."""
        return np.ascontiguousarray(self.organised[self.labels < GENUINE][:, :3])


def path_through(world: simulation.World, num_scans: int) -> Array:
    """Returns (n, 4, 4) poses of the sensor: straight ahead, giving way to trunks sideways."""
    def room(x: float, y: float) -> float:
        p = np.array([[x, y, world.ground_height(x, y) + HEIGHT_M]])
        return float(world.clearance(p, 1.5)[0]) - 0.01 * abs(y)

    poses, y = [], 0.0
    for i in range(num_scans):
        x = STEP_M * i
        y = max((y, y - 0.15, y + 0.15), key=lambda at: room(x + 1.0, at))
        poses.append(simulation.pose(x, y, world.ground_height(x, y) + HEIGHT_M, 0.2 * np.sin(0.1 * i)))
    return np.array(poses)


def fly(world: simulation.World, poses: Array, seed: int, sensor: dict[str, Any]) -> Iterator[AimedScan]:
    """Yields one scan for each pose of the sensor. sensor: fields of LidarConfig."""
    lidar = simulation.Lidar(seed=seed, **sensor)
    exact = simulation.Lidar(seed=seed, **dict(
        sensor, footprint_rays=1, range_noise_m=0.0, dropout_ratio=0.0, ghost_ratio=0.0, speckle_ratio=0.0,
        rain_mm_per_h=0.0, min_signal=0.0))
    for i, T_W_L in enumerate(poses):
        measured, true = lidar.scan(world, T_W_L, T_W_L, i), exact.scan(world, T_W_L, T_W_L, i)
        is_surface = true.labels < GENUINE
        surface_L = true.organised[is_surface][:, :3]
        yield AimedScan(T_W_L, measured.organised, measured.labels,
                        surface_L @ T_W_L[:3, :3].T + T_W_L[:3, 3], true.labels[is_surface])
