# SPDX-License-Identifier: BSD-3-Clause
"""The outputs of the planner for people: status, path markers, and a line for mrs_uav_status."""

import numpy as np
import rospy
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, String
from visualization_msgs.msg import Marker, MarkerArray

from voxnav.msg import PlannerStatus

STATE_NAMES = ("IDLE", "PLAN", "MOVE")
STATE_COLOURS = ("", "-y ", "-g ")
MAX_LINE = 30  # characters that mrs_uav_status shows
MAX_MARKER_POINTS = 500


def points_of(array):
    step = max(1, len(array) // MAX_MARKER_POINTS)
    kept = list(array[::step]) + ([array[-1]] if len(array) else [])
    return [Point(*(float(x) for x in p)) for p in kept]


def marker(frame, stamp, name, kind, colour, size, points=()):
    out = Marker(ns=name, id=0, type=kind, action=Marker.ADD if len(points) else Marker.DELETE)
    out.header.frame_id, out.header.stamp = frame, stamp
    out.pose.orientation.w = 1.0
    out.color = ColorRGBA(*colour)
    out.scale.x = size
    if kind in (Marker.SPHERE, Marker.TRIANGLE_LIST):
        out.scale.y = out.scale.z = size
    if kind == Marker.SPHERE:
        if len(points):
            out.pose.position = points[0]
    else:
        out.points = list(points)
    return out


class PlanningOutput:
    def __init__(self):
        self._status = rospy.Publisher("~status_out", PlannerStatus, queue_size=5, latch=True)
        self._display = rospy.Publisher("~display_string_out", String, queue_size=2)
        self._markers = rospy.Publisher("~path_markers_out", MarkerArray, queue_size=2, latch=True)

    def publish(self, stamp, status, home, way_home_W, inputs, path_O, waypoints_O, position_W):
        """Publishes a status of voxnav.planning_manager, the way home, and paths.

        home: a HomeState; way_home_W: (k, 3), None if it is not known; path_O, waypoints_O: (k, 3)
        """
        self._publish_status(status, home, inputs, stamp, position_W, waypoints_O)
        flags = "-id planning_manager -p " + STATE_COLOURS[status.state]
        line = "%s: %s" % (STATE_NAMES[status.state], status.reason)
        self._display.publish(String(data=flags + line[:MAX_LINE]))
        if self._markers.get_num_connections() == 0:
            return
        O, W = inputs.odometry_frame, inputs.map_frame
        goal = status.goal_W
        self._markers.publish(MarkerArray(markers=[
            marker(O, stamp, "trajectory", Marker.LINE_STRIP, (0.1, 0.9, 0.2, 1.0), 0.12, points_of(path_O)),
            marker(O, stamp, "plan", Marker.LINE_STRIP, (1.0, 0.8, 0.1, 0.8), 0.06, points_of(waypoints_O)),
            marker(W, stamp, "way_home", Marker.LINE_STRIP, (0.4, 0.6, 1.0, 0.6), 0.05,
                   () if way_home_W is None else points_of(way_home_W)),
            marker(W, stamp, "goal", Marker.SPHERE, (0.9, 0.2, 0.2, 0.9), 0.8,
                   () if goal is None else points_of(np.array([goal]))),
        ]))

    def _publish_status(self, status, home, inputs, stamp, position_W, waypoints_O):
        out = PlannerStatus(state=status.state, reason=status.reason)
        out.header.frame_id, out.header.stamp = inputs.map_frame, stamp
        out.refusal = "" if status.refusal is None else status.refusal.sentence
        T_W_O = inputs.T_W_O
        out.has_plan = T_W_O is not None and len(waypoints_O) > 0
        if out.has_plan:
            out.plan_end = Point(*(float(x) for x in T_W_O[:3, :3].dot(waypoints_O[-1]) + T_W_O[:3, 3]))
        for name in ("is_goal_reached", "plan_status", "expansions", "plan_s", "num_plans", "num_trajectories",
                     "num_shortened", "num_hovers"):
            setattr(out, name, getattr(status, name))
        goal = status.goal_W
        out.has_goal = goal is not None
        if goal is not None:
            out.goal = Point(*(float(x) for x in goal))
        if goal is not None and position_W is not None:
            out.goal_distance_m = float(np.linalg.norm(goal - position_W))
        out.has_home, out.is_way_home_known = home.start_W is not None, home.way_s is not None
        if out.has_home:
            out.home = Point(*(float(x) for x in home.start_W))
        if out.is_way_home_known:
            out.way_home_m, out.way_home_s = home.way_m, home.way_s
        self._status.publish(out)
