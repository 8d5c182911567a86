# SPDX-License-Identifier: BSD-3-Clause
"""Helpers that several tests of nodes share."""

import time

import rospy
from sensor_msgs.msg import PointCloud2, PointField

TIMEOUT_S = 20.0
FIELD_TYPES = {"<f4": PointField.FLOAT32, "|u1": PointField.UINT8, "<u4": PointField.UINT32, "<u2": PointField.UINT16}


def wait_for(condition, timeout_s=TIMEOUT_S):
    """Waits until condition() is true or the time is over, and returns its last result."""
    end = time.time() + timeout_s
    while not condition() and time.time() < end:
        time.sleep(0.02)
    return condition()


def cloud_message(points, stamp_s, frame_id="uav1/os_sensor"):
    """Returns a PointCloud2 with the fields of a structured array of shape (width,) or (height, width)."""
    height, width = points.shape if points.ndim == 2 else (1, len(points))
    msg = PointCloud2(height=height, width=width, point_step=points.dtype.itemsize)
    msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(stamp_s), frame_id
    msg.row_step, msg.data = msg.point_step * width, points.tobytes()
    for name in points.dtype.names:
        field_type, offset = points.dtype.fields[name]
        msg.fields.append(PointField(name, offset, FIELD_TYPES[field_type.str], 1))
    return msg
