# SPDX-License-Identifier: BSD-3-Clause
"""voxnav: LiDAR mapping and planning for UAVs.

Everything here needs no ROS: the C++ core, and the planning manager on top of it. ``voxnav.nodes`` holds the rospy
nodes. Frames, units and array shapes: docs/architecture.md.
"""

from voxnav._core import *  # noqa: F401,F403
from voxnav.planning_manager import PlanningManager  # noqa: F401
