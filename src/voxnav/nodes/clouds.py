# SPDX-License-Identifier: BSD-3-Clause
"""Converts between PointCloud2 messages and numpy arrays."""

import numpy as np

import voxnav
from voxnav.recordings.cloud_samples import layout_of
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


_STEPS_PER_S = {voxnav.TimeUnit.S: 1, voxnav.TimeUnit.MS: 10**3, voxnav.TimeUnit.US: 10**6, voxnav.TimeUnit.NS: 10**9}
_FLOATS = {7: "<f4", 8: "<f8"}
_TIME_TYPES = {**_FLOATS, 9: "<i8", 10: "<u8"}  # types that can hold times since the epoch of the stamps


def shift_time(cloud, offset_ns, times):
    """Moves the stamp of a PointCloud2 by offset_ns, and its point times too if they count from the same epoch.

    times: voxnav.PointTimes of the sensor, to which this cloud is added. Raises ValueError for an invalid layout.
    """
    stamp_ns = cloud.header.stamp.to_nsec()
    is_timed = times.judge(bytes(cloud.data), layout_of(cloud), stamp_ns)
    moved_ns = stamp_ns + offset_ns
    cloud.header.stamp.secs, cloud.header.stamp.nsecs = moved_ns // 10**9, moved_ns % 10**9
    report = times.report
    field = next((f for f in cloud.fields if f.name == report.field), None)
    if not is_timed or report.zero != voxnav.TimeZero.ROS_TIME or not offset_ns or field is None:
        return
    data = bytearray(cloud.data)
    row_step = cloud.width * cloud.point_step
    if len(data) >= (cloud.height - 1) * cloud.row_step + row_step:  # else row_step is wrong and the rows are packed
        row_step = max(row_step, cloud.row_step)
    steps = offset_ns * _STEPS_PER_S[report.unit]
    values = np.ndarray((cloud.height, cloud.width), _TIME_TYPES[field.datatype], data, field.offset,
                        (row_step, cloud.point_step))
    values += values.dtype.type(steps / 10**9 if field.datatype in _FLOATS else steps // 10**9)
    cloud.data = bytes(data)


def points_to_msg(points, header):
    """Returns a PointCloud2 with x y z (and intensity for four columns) float32. points: (n, 3) or (n, 4)."""
    points = np.ascontiguousarray(points, dtype="<f4")
    names = ("x", "y", "z", "intensity")[:points.shape[1]]
    fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate(names)]
    step = 4 * len(names)
    return PointCloud2(header=header, height=1, width=len(points), fields=fields, is_bigendian=False, point_step=step,
                       row_step=step * len(points), data=points.tobytes(), is_dense=True)
