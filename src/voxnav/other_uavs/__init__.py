# SPDX-License-Identifier: BSD-3-Clause
"""Other UAVs, which announce where they will be (mrs_msgs/FutureTrajectory), without ROS.

trajectories reads what they announce; keeper keeps the last of each, tells where it may be by now, and who gives way;
origin keeps the transform by which they are placed.
"""

from voxnav.other_uavs.keeper import Keeper, Other, has_right_of_way
from voxnav.other_uavs.origin import KeptTransform, OriginUnknown
from voxnav.other_uavs.trajectories import Announced, AnnouncementError, begin_of

__all__ = ["Announced", "AnnouncementError", "Keeper", "KeptTransform", "OriginUnknown", "Other", "begin_of",
           "has_right_of_way"]
