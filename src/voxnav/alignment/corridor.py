# SPDX-License-Identifier: BSD-3-Clause
"""An endless corridor and a LiDAR in it: the scans do not show how far along the corridor the vehicle is."""

from __future__ import annotations

import numpy as np

from voxnav.array_types import Array, ArrayLike

_BOX_M = ((-1e6, 1e6), (-3.0, 3.0), (0.0, 4.0))


class Corridor:
    """A corridor without end along x, with walls at y = +-3 m, the floor at z = 0 and the ceiling at 4 m."""

    def ground_height(self, x: ArrayLike, y: ArrayLike) -> Array:
        return np.zeros(np.broadcast(x, y).shape)

    def clearance(self, points: Array, max_m: float = 100.0) -> Array:
        out = np.full(len(points), max_m)
        for axis in (1, 2):
            for side in _BOX_M[axis]:
                out = np.minimum(out, np.abs(points[:, axis] - side))
        return out

    def surface_distance(self, points: Array, max_m: float = 100.0) -> Array:
        return self.clearance(points, max_m)


class CorridorLidar:
    """A LiDAR with 32 x 512 beams over 90 degrees of elevation, and 2 cm of noise."""

    def __init__(self, seed: int) -> None:
        self._random = np.random.RandomState(seed)
        elevation = np.radians(np.linspace(45.0, -45.0, 32))[:, None]
        azimuth = np.linspace(0.0, 2.0 * np.pi, 512, endpoint=False)[None, :]
        self._beams = np.stack(np.broadcast_arrays(np.cos(elevation) * np.cos(azimuth),
                                                   np.cos(elevation) * np.sin(azimuth), np.sin(elevation)), axis=-1)

    def organised(self, T_W_L: Array) -> Array:
        """The organised cloud of one scan: (32, 512, 4) float32 x y z intensity, sensor frame."""
        beams_W = self._beams @ T_W_L[:3, :3].T
        ranges = np.full(beams_W.shape[:2], np.inf)
        for axis in (1, 2):
            for side in _BOX_M[axis]:
                with np.errstate(divide="ignore", invalid="ignore"):
                    hit = (side - T_W_L[axis, 3]) / beams_W[..., axis]
                ranges = np.where(hit > 0.0, np.minimum(ranges, hit), ranges)
        is_return = ranges < 60.0
        ranges = np.where(is_return, ranges + 0.02 * self._random.randn(*ranges.shape), 0.0)
        cloud = np.concatenate([self._beams * ranges[..., None], 200.0 * is_return[..., None]], axis=-1)
        return np.ascontiguousarray(cloud, dtype=np.float32)
