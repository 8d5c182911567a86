# SPDX-License-Identifier: BSD-3-Clause
"""Takes goals from topics and services in any frame, and converts them to the map frame W."""

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from mrs_msgs.msg import ReferenceStamped
from mrs_msgs.srv import (ReferenceStampedSrv, ReferenceStampedSrvResponse, TransformReferenceSrvRequest, Vec4,
                          Vec4Response)
from std_srvs.srv import Trigger, TriggerResponse

from voxnav.nodes.planning_inputs import matrix
from voxnav.nodes.planning_services import ServiceError, reference

# The name by which MRS takes latitudes and longitudes [deg] as x and y; tf does not know it.
LATLON = "latlon_origin"


class GoalError(ValueError):
    """The goal cannot be used; the text says why."""


def yaw_of(R):
    return float(np.arctan2(R[1, 0], R[0, 0]))


class PlanningGoals:
    """Calls set_goal(goal_W, heading_W or None), which returns a problem, and stop(), which returns a text."""

    def __init__(self, inputs, uav_name, set_goal, stop, transform):
        """transform: TimedService of the MRS control manager for references in frames that tf does not know."""
        self._inputs, self._uav_name, self._set_goal, self._stop = inputs, uav_name, set_goal, stop
        self._transform = transform
        rospy.Subscriber("~goal_in", PoseStamped, self._on_goal, queue_size=1)
        rospy.Subscriber("~reference_in", ReferenceStamped, self._on_reference, queue_size=1)
        rospy.Service("~reference", ReferenceStampedSrv, self._serve_reference)
        rospy.Service("~goto", Vec4, self._serve_goto)
        rospy.Service("~stop", Trigger, self._serve_stop)

    def _on_goal(self, msg):
        p, q = msg.pose.position, msg.pose.orientation
        try:
            heading = yaw_of(matrix(p, q))
        except ValueError:
            heading = None  # a message without orientation leaves the heading free
        # rviz clicks on the ground plane: the altitude stays as it is.
        self._report(self._take(msg.header.frame_id, (p.x, p.y, p.z), heading, keeps_altitude=p.z == 0.0))

    def _on_reference(self, msg):
        p = msg.reference.position
        self._report(self._take(msg.header.frame_id, (p.x, p.y, p.z), msg.reference.heading))

    def _serve_reference(self, request):
        p = request.reference.position
        problem = self._take(request.header.frame_id, (p.x, p.y, p.z), request.reference.heading)
        return ReferenceStampedSrvResponse(success=not problem, message=problem or "goal taken")

    def _serve_goto(self, request):
        problem = self._take("", request.goal[:3], request.goal[3])
        return Vec4Response(success=not problem, message=problem or "goal taken")

    def _serve_stop(self, _):
        return TriggerResponse(success=True, message=self._stop())

    def _report(self, problem):
        if problem:
            rospy.logwarn("goal refused: %s", problem)

    def _take(self, frame, position, heading, keeps_altitude=False):
        """Sets a goal. Returns why it is refused, or ''."""
        try:
            if not np.isfinite(position).all() or (heading is not None and not np.isfinite(heading)):
                return "goal is not finite"
            if frame.split("/")[-1] == LATLON:
                frame, position, heading = self._ask_control(frame, position, heading)
            T_W_F = self.to_map(frame)
            goal_W = T_W_F[:3, :3].dot(position) + T_W_F[:3, 3]
            if keeps_altitude:
                goal_W[2] = self._altitude()
        except GoalError as error:
            return str(error)
        heading_W = None if heading is None else heading + yaw_of(T_W_F)
        return self._set_goal(goal_W, heading_W)

    def _ask_control(self, frame, position, heading):
        """Lets the MRS control manager, which knows where on earth it is, express a goal in the control frame."""
        request = TransformReferenceSrvRequest(frame_id=self._inputs.odometry_frame)
        request.reference.header.frame_id = frame
        request.reference.reference = reference(position, heading or 0.0)
        try:
            answer = self._transform.call(request)
        except ServiceError as error:
            raise GoalError("frame '%s' cannot be transformed: %s" % (frame, error))
        if not answer.success:
            raise GoalError("frame '%s' cannot be transformed: %s" % (frame, answer.message or "refused"))
        out = answer.reference
        p = out.reference.position
        return out.header.frame_id, (p.x, p.y, p.z), None if heading is None else out.reference.heading

    def _altitude(self):
        position = self._inputs.position_O
        if position is None or self._inputs.T_W_O is None:
            raise GoalError("the goal has no altitude, and the vehicle's own is not known yet")
        T = self._inputs.T_W_O
        return float(T[2, :3].dot(position) + T[2, 3])

    def to_map(self, frame):
        """Returns T_W_F. An empty frame is the control frame, as in MRS; a short name belongs to this UAV."""
        inputs = self._inputs
        names = [frame] if "/" in frame or not self._uav_name else [frame, self._uav_name + "/" + frame]
        if inputs.map_frame in names:
            return np.eye(4)
        if inputs.T_W_O is None:
            raise GoalError("no map correction yet: the place of frame '%s' is not known" % (frame or "control"))
        if not frame or inputs.odometry_frame in names:
            return inputs.T_W_O
        try:
            return inputs.T_W_O.dot(inputs.T_O_of(frame, names))
        except LookupError as error:
            raise GoalError(str(error))
