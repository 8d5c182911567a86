# SPDX-License-Identifier: BSD-3-Clause
"""voxnav: LiDAR mapping and planning for UAVs.

This package offers the C++ core and, on top of it, the planning manager; neither needs ROS. ``voxnav.nodes`` holds the
rospy nodes. docs/architecture.md explains the frames, docs/terminology.md the words.
"""

from voxnav._core import *  # noqa: F401,F403
from voxnav.planning_manager import PlanningManager  # noqa: F401
