# SPDX-License-Identifier: BSD-3-Clause
"""What stands in for mrs_octomap_server and mrs_octomap_planner, without ROS: names of maps, altitudes, configurations.

The nodes that use it are octomap_server, octomap_planner and bumper of voxnav.nodes; docs/mrs.md compares the two.
"""

from voxnav.octomap_face.altitude import ground_height_m, offset_m
from voxnav.octomap_face.map_names import MapNameError, map_path

__all__ = ["MapNameError", "ground_height_m", "map_path", "offset_m"]
