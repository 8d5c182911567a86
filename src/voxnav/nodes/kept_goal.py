# SPDX-License-Identifier: BSD-3-Clause
"""Keeps the planner's goal on the parameter server, so that a restarted node continues the flight."""

import numpy as np
import rospy

# A goal kept on the parameter server is forgotten after this time.
MAX_AGE_S = 600.0


class KeptGoal:
    def __init__(self, node, is_enabled):
        """Makes the keeper of a node's goal. is_enabled: False keeps nothing."""
        self._name, self._is_enabled, self._kept = rospy.get_namespace() + node + "_kept_goal", is_enabled, None

    def keep(self, goal_W):
        """Keeps a goal; None forgets the one before."""
        kept = None if goal_W is None else [float(x) for x in goal_W]
        if not self._is_enabled or kept == self._kept:
            return
        self._kept = kept
        stamp_s = rospy.Time.now().to_sec()
        rospy.set_param(self._name, {"goal_W": kept, "stamp_s": stamp_s} if kept else {"stamp_s": stamp_s})

    def find(self):
        """Returns the goal of the node before its restart, (3,); None if there was none, or long ago."""
        kept, now_s = rospy.get_param(self._name, {}), rospy.Time.now().to_sec()
        if not self._is_enabled or "goal_W" not in kept:
            return None
        is_recent = 0.0 <= now_s - kept["stamp_s"] < MAX_AGE_S or now_s == 0.0
        return np.array(kept["goal_W"]) if is_recent else None
