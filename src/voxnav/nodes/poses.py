# SPDX-License-Identifier: BSD-3-Clause
"""Conversions between poses of messages and (4, 4) matrices."""

import numpy as np
from geometry_msgs.msg import Pose, Transform

import voxnav


def pose_from_msg(msg):
    """Returns the (4, 4) matrix of a geometry_msgs/Pose. Raises ValueError if it is not finite or has no rotation."""
    p, q = msg.position, msg.orientation
    return voxnav.pose_from_quaternion((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def pose_to_msg(T):
    out = Pose()
    out.position.x, out.position.y, out.position.z = T[:3, 3]
    q = out.orientation
    q.x, q.y, q.z, q.w = voxnav.quaternion_of(np.ascontiguousarray(T))
    return out


def transform_to_msg(T):
    pose = pose_to_msg(T)
    return Transform(translation=pose.position, rotation=pose.orientation)
