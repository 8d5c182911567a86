# SPDX-License-Identifier: BSD-3-Clause
"""voxnav: LiDAR mapping and planning for UAVs.

Everything here comes from the C++ core and needs no ROS; ``voxnav.nodes`` holds the rospy nodes.
Frames, units and array shapes: docs/architecture.md.
"""

from voxnav._core import *  # noqa: F401,F403
