# SPDX-License-Identifier: BSD-3-Clause
"""Virtual obstacles as mrs_octomap_planner takes them, which are no-fly zones of the planner's fences."""

import itertools

import rospy
from mrs_msgs.srv import ValidateReferenceArray, ValidateReferenceArrayResponse
from std_srvs.srv import Trigger, TriggerResponse

from voxnav.fences import FenceError, virtual_obstacle

# The zones of virtual obstacles are told apart from others by their names.
PREFIX = "virtual_obstacle_"


class VirtualObstacles:
    """Offers ~add_virtual_obstacle, three corners in one frame, and ~remove_virtual_obstacles, for all of them."""

    def __init__(self, fences, inputs):
        """fences: PlanningFences; inputs: PlanningInputs, whose odometry frame an empty frame stands for"""
        self._fences, self._inputs = fences, inputs
        self._numbers = itertools.count(1)
        rospy.Service("~add_virtual_obstacle", ValidateReferenceArray, self._serve_add)
        rospy.Service("~remove_virtual_obstacles", Trigger, self._serve_remove)

    def _serve_add(self, request):
        points = [(each.position.x, each.position.y, each.position.z) for each in request.array.array]
        frame = request.array.header.frame_id or self._inputs.odometry_frame
        try:
            said = self._fences.add(virtual_obstacle(PREFIX + str(next(self._numbers)), frame, points))
        except FenceError as error:
            rospy.logwarn("virtual obstacle refused: %s", error)
            return ValidateReferenceArrayResponse(success=[False], message=str(error))
        return ValidateReferenceArrayResponse(success=[True], message=said)

    def _serve_remove(self, _):
        return TriggerResponse(success=True, message="%d virtual obstacles removed" % self._fences.clear(PREFIX))
