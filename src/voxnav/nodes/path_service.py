# SPDX-License-Identifier: BSD-3-Clause
"""Searches paths by service, without a goal and without flying: what the minimal planner of MRS offers."""

import threading

import numpy as np
import rospy
from geometry_msgs.msg import Point

import voxnav
from voxnav.nodes.planning_goals import GoalError
from voxnav.srv import FindPath, FindPathResponse


class PathService:
    """Offers ~find_path, which searches on the present map with a clearance field of its own."""

    def __init__(self, settings, view, to_map, frames):
        """Offers the service.

        settings: PlanningSettings; view() returns the map, or None; to_map(frame) returns T_W_F or raises GoalError;
        frames() returns T_W_O, or None, and the name of frame O
        """
        self._settings, self._view, self._to_map, self._frames = settings, view, to_map, frames
        self._lock = threading.Lock()
        self._revision, self._search = 0, None  # made by the first request, since its field takes memory
        rospy.Service("~find_path", FindPath, self._serve)

    def _serve(self, request):
        try:
            with self._lock:
                return self._find(request)
        except (GoalError, ValueError) as error:
            return FindPathResponse(header=request.header, success=False, message=str(error))

    def _find(self, request):
        view, (T_W_O, frame_O) = self._view(), self._frames()
        if view is None or T_W_O is None:
            raise ValueError("there is no map yet")
        T_O_F = np.linalg.inv(T_W_O).dot(self._to_map(request.header.frame_id or frame_O))
        ends_O = [T_O_F[:3, :3].dot((p.x, p.y, p.z)) + T_O_F[:3, 3] for p in (request.start, request.end)]
        if not np.isfinite(ends_O).all():
            raise ValueError("start or end is not finite")
        self._revision, self._search = self._settings.search(self._revision, self._search)
        self._search.field.update(view)
        plan = self._search.planner.plan(self._search.field, *ends_O)
        return self._answer(request, plan, np.linalg.inv(T_O_F), frame_O)

    @staticmethod
    def _answer(request, plan, T_F_O, frame_O):
        path = plan.path.dot(T_F_O[:3, :3].T) + T_F_O[:3, 3]
        out = FindPathResponse(header=request.header, success=len(path) > 0)
        out.header.frame_id = request.header.frame_id or frame_O
        out.path = [Point(*(float(x) for x in p)) for p in path]
        if plan.status == voxnav.PlanStatus.COMPLETE:
            out.message = "path of %.1f m" % plan.length_m
        elif len(path):
            out.message = "path of %.1f m, which ends %.1f m before the end: %s" % (
                plan.length_m, plan.remaining_m, plan.reason)
        else:
            out.message = "no path: %s" % plan.reason
        return out
