# SPDX-License-Identifier: BSD-3-Clause
"""The origins of the odometry, one after another, and how poses in former ones are expressed in the newest."""

import enum

import numpy as np

from voxnav.nodes.poses import pose_from_msg


class Change(enum.Enum):
    """What a message means for what was expressed in the origin before."""

    NONE = 0  # the origin is the same, or the first one
    RELATED = 1
    UNRELATED = 2


class GraphOrigins:
    """Follows the messages OdometryOrigin of the local mapper.

    They are sent again to those who come late, and a mapper that was restarted does not know the origin before.
    """

    def __init__(self, frame):
        """frame: the newest origin until a message, or a submap, names it."""
        self.frame = frame
        self._is_named, self._former = False, {}  # {frame: T_newest_frame}

    def follow(self, msg):
        """Takes over the origin of a message. Returns the Change, and if it is RELATED T_new_old (4, 4)."""
        frame, before = msg.header.frame_id, self.frame
        if not self._is_named or frame == before:
            self._is_named, self.frame = True, frame
            return Change.NONE, None
        self.frame = frame
        T_now_previous = np.eye(4) if msg.previous_frame == before else self._former.get(msg.previous_frame)
        if not msg.is_related or T_now_previous is None:
            self._former = {}
            return Change.UNRELATED, None
        T_new_old = pose_from_msg(msg.T_O_previous) @ np.linalg.inv(T_now_previous)
        self._former = {name: T_new_old @ T for name, T in self._former.items() if name != frame}
        self._former[before] = T_new_old
        return Change.RELATED, T_new_old

    def into(self, frame):
        """Returns T_newest_frame (4, 4). Raises ValueError for an origin that does not relate to the newest."""
        if not frame or frame == self.frame:
            return np.eye(4)
        if not self._is_named:
            self._is_named, self.frame = True, frame
            return np.eye(4)
        if frame not in self._former:
            raise ValueError("frame %s does not relate to %s" % (frame, self.frame))
        return self._former[frame]

    def express(self, frame, T_frame_X):
        """Returns T_newest_X of a pose in an origin; as it is to the last bit in the newest one, where -0 stays -0."""
        T_newest_frame = self.into(frame)
        return T_frame_X if np.array_equal(T_newest_frame, np.eye(4)) else T_newest_frame @ T_frame_X
