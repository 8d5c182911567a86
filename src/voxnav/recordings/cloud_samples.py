# SPDX-License-Identifier: BSD-3-Clause
"""Measures a cloud of a recording: its fields, its reach, and the share of the horizon that it covers."""

from __future__ import annotations

from typing import Any

import numpy as np

import voxnav
from voxnav.array_types import Array

LIDAR_FIELDS = ("ring", "line", "intensity", "reflectivity", "tag", "ambient", "noise", "range")
_DATATYPES = {1: "int8", 2: "uint8", 3: "int16", 4: "uint16", 5: "int32", 6: "uint32", 7: "float32", 8: "float64"}


def layout_of(msg: Any) -> voxnav.CloudLayout:
    """Returns the layout of a sensor_msgs/PointCloud2. Raises ValueError for fields of an unknown type."""
    fields = [(f.name, f.offset, f.datatype, f.count) for f in msg.fields]
    return voxnav.CloudLayout(msg.height, msg.width, msg.point_step, fields, row_step=msg.row_step,
                              is_big_endian=bool(msg.is_bigendian))


class CloudSample:
    """Figures of one cloud. problem: the reason if it cannot be read, else None; its figures are zero in that case."""

    def __init__(self, msg: Any) -> None:
        self.fields = {f.name: _DATATYPES.get(f.datatype, "type %d" % f.datatype) for f in msg.fields}
        self.height, self.width = int(msg.height), int(msg.width)
        self.num_bytes = len(msg.data)
        self.num_returns, self.reach_m, self.horizon = 0, 0.0, 0.0
        self.problem: str | None = None
        try:
            points = voxnav.read_sweep(msg.data, layout_of(msg)).points
        except ValueError as error:
            self.problem = str(error)
            return
        self._measure(points)

    def _measure(self, points: Array) -> None:
        """Measures reach_m, within which 95 % of the returns are, and horizon, the share of headings with returns."""
        points = points[np.all(np.isfinite(points), axis=1)]
        ranges = np.linalg.norm(points, axis=1)
        is_return = ranges > 0.1  # drivers fill in nearer points where there was no return
        points, ranges = points[is_return], ranges[is_return]
        self.num_returns = len(points)
        if not len(points):
            return
        self.reach_m = float(np.percentile(ranges, 95))
        headings = np.floor((np.arctan2(points[:, 1], points[:, 0]) + np.pi) / (2 * np.pi) * 72).astype(int)
        self.horizon = len(np.unique(np.clip(headings, 0, 71))) / 72.0
