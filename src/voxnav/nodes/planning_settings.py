# SPDX-License-Identifier: BSD-3-Clause
"""What of the planner can be changed in flight: the safety distance and the highest altitude."""

import threading

import numpy as np
import rospy
from mrs_msgs.srv import Vec1, Vec1Response

import voxnav


class Search:
    """A path planner with the clearance field on which it searches. Only one thread may use the field at a time."""

    def __init__(self, config):
        """config: voxnav.FlightSearchConfig"""
        self.planner = voxnav.PathPlanner(config.planner_config())
        self.field = voxnav.ClearanceField(config.field_config())


class PlanningSettings:
    """Offers ~set_safety_distance and ~set_max_altitude, and makes searches by the present settings."""

    def __init__(self, search, limits, manager, take_altitudes):
        """Offers the services.

        search: voxnav.FlightSearchConfig; limits: voxnav.NavigationMapConfig; manager: voxnav.PlanningManagerConfig;
        take_altitudes(min_m, max_m) passes changed altitudes on
        """
        self._config, self._take_altitudes = search, take_altitudes
        self._altitudes_m = (limits.min_altitude_m, limits.max_altitude_m)
        self._flown_m = manager.corridor_radius_m + manager.trajectory_deviation_m
        if limits.zone_distance_m < self._flown_m:
            rospy.logwarn("map/zone_distance_m %.2f m is less than the %.2f m that what is flown may need beside a "
                          "zone (manager/corridor_radius_m and trajectory_deviation_m): trajectories there may be "
                          "refused",
                          limits.zone_distance_m, self._flown_m)
        self._lock = threading.Lock()
        self._revision = 0  # rises with every change that makes earlier searches void
        rospy.Service("~set_safety_distance", Vec1, self._serve_distance)
        rospy.Service("~set_max_altitude", Vec1, self._serve_altitude)

    def search(self, revision, search):
        """Returns (revision, Search) that are up to date, the given ones if nothing has changed."""
        with self._lock:
            if search is not None and revision == self._revision:
                return revision, search
            return self._revision, Search(self._config)

    def _serve_distance(self, request):
        try:
            changed = voxnav.FlightSearchConfig.from_dict(dict(self._config.to_dict(), safety_distance_m=request.goal))
        except (voxnav.ConfigError, ValueError, OverflowError) as error:
            return Vec1Response(success=False, message="safety distance not set: %s" % error)
        with self._lock:
            self._config = changed
            self._revision += 1
        said = "safety distance set to %.2f m" % request.goal
        if request.goal < self._flown_m:
            said += ("; what is flown keeps %.2f m in any case (manager/corridor_radius_m and trajectory_deviation_m)"
                     % self._flown_m)
        rospy.loginfo(said)
        return Vec1Response(success=True, message=said)

    def _serve_altitude(self, request):
        low_m = self._altitudes_m[0]
        if not np.isfinite(request.goal) or request.goal <= low_m:
            problem = "max altitude not set: %.2f m is not above the lowest one of %.2f m" % (request.goal, low_m)
            return Vec1Response(success=False, message=problem)
        try:
            self._take_altitudes(low_m, request.goal)
        except voxnav.ConfigError as error:
            return Vec1Response(success=False, message="max altitude not set: %s" % error)
        with self._lock:
            self._altitudes_m = (low_m, request.goal)
            self._revision += 1
        said = "max altitude set to %.2f m" % request.goal
        rospy.loginfo(said)
        return Vec1Response(success=True, message=said)
