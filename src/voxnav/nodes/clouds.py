# SPDX-License-Identifier: BSD-3-Clause
"""PointCloud2 messages and numpy."""

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField


def points_from_msg(cloud):
    """Returns (n, 3) float32 of a PointCloud2 whose x, y, z are float32; rows that are not finite are left out.

    Raises ValueError naming the field that is missing or of another type.
    """
    offsets = []
    for name in "xyz":
        fields = [f for f in cloud.fields if f.name == name]
        if not fields or fields[0].datatype != PointField.FLOAT32:
            raise ValueError("cloud has no float32 field %s" % name)
        offsets.append(fields[0].offset)
    count = cloud.width * cloud.height
    if len(cloud.data) < count * cloud.point_step:
        raise ValueError("cloud announces %d points and holds bytes for %d" % (
            count, len(cloud.data) // max(cloud.point_step, 1)))
    dtype = np.dtype({"names": list("xyz"), "formats": ["<f4"] * 3, "offsets": offsets, "itemsize": cloud.point_step})
    rows = np.frombuffer(cloud.data, dtype=dtype, count=count)
    points = np.stack([rows["x"], rows["y"], rows["z"]], axis=1)
    return points[np.all(np.isfinite(points), axis=1)]


def points_to_msg(points, header):
    """Returns a PointCloud2 with x y z (and intensity for four columns) float32. points: (n, 3) or (n, 4)."""
    points = np.ascontiguousarray(points, dtype="<f4")
    names = ("x", "y", "z", "intensity")[:points.shape[1]]
    fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate(names)]
    step = 4 * len(names)
    return PointCloud2(header=header, height=1, width=len(points), fields=fields, is_bigendian=False, point_step=step,
                       row_step=step * len(points), data=points.tobytes(), is_dense=True)
