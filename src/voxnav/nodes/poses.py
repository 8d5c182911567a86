# SPDX-License-Identifier: BSD-3-Clause
"""Poses of messages and (4, 4) matrices."""

import numpy as np
from geometry_msgs.msg import Pose, Transform

from voxnav import files


def pose_from_msg(msg):
    """(4, 4) of a geometry_msgs/Pose. Raises ValueError when it is not finite or has no rotation."""
    out = np.eye(4)
    out[:3, 3] = [msg.position.x, msg.position.y, msg.position.z]
    q = msg.orientation
    out[:3, :3] = files.rotation_from_quaternion([q.x, q.y, q.z, q.w])
    if not np.all(np.isfinite(out)):
        raise ValueError("pose is not finite")
    return out


def pose_to_msg(T):
    out = Pose()
    out.position.x, out.position.y, out.position.z = T[:3, 3]
    q = out.orientation
    q.x, q.y, q.z, q.w = files.quaternion_from_rotation(T[:3, :3])
    return out


def transform_to_msg(T):
    pose = pose_to_msg(T)
    return Transform(translation=pose.position, rotation=pose.orientation)
