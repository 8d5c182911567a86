# SPDX-License-Identifier: BSD-3-Clause
"""Publishes the nearest obstacles in the sectors around the vehicle, from the local map, for the bumper of MRS.

The control manager repels the vehicle from what is near in these sectors, and stops to do so only when a message says
that nothing is near any more. So messages never cease: without a map they say that nothing is known.
"""

import numpy as np
import rospy
from mrs_msgs.msg import ObstacleSectors
from nav_msgs.msg import Odometry

import voxnav
from voxnav.msg import NodeDiagnostics
from voxnav.nodes.node_base import Diagnostics, run_node
from voxnav.nodes.params import load_sections
from voxnav.nodes.planning_feeds import GridFeed
from voxnav.nodes.planning_inputs import rotation
from voxnav.nodes.time_seam import RealTime

NAME = "bumper"


def empty_map():
    """Returns a NavigationMap that holds the local map alone, without altitudes and without the vehicle's footprint."""
    out = voxnav.NavigationMap(voxnav.NavigationMapConfig(
        min_altitude_m=-1000.0, max_altitude_m=9000.0, footprint_radius_m=0.0, footprint_half_height_m=0.0))
    out.set_T_W_O(np.eye(4))
    return out


class BumperNode:
    def __init__(self):
        self._config, self._sectors = load_sections(node=voxnav.BumperNodeConfig, sectors=voxnav.ObstacleSectorsConfig)
        self._diagnostics = Diagnostics(NAME)
        self._map, seam = empty_map(), RealTime()
        self._map_heard = self._odometry_heard = self._odometry = None
        self._num_bad = 0
        self._publisher = rospy.Publisher("~obstacle_sectors_out", ObstacleSectors, queue_size=2)
        self._feed = GridFeed("~local_map_in", "~get_map_out", self._map.apply_local, self._on_map,
                              self._config.service_timeout_s, seam)
        rospy.Subscriber("~odometry_in", Odometry, self._on_odometry, queue_size=1)
        seam.every(self._config.rate_hz, self._publish)

    def _on_map(self, _):
        self._map_heard = RealTime.mark()

    def _on_odometry(self, msg):
        p = msg.pose.pose.position
        try:
            R = rotation(msg.pose.pose.orientation)
            if not np.isfinite((p.x, p.y, p.z)).all():
                raise ValueError("the position is not finite")
        except ValueError as error:
            self._num_bad += 1
            self._diagnostics.set_counter("num_bad_inputs", self._num_bad)
            rospy.logwarn_throttle(5.0, "[%s]: odometry refused: %s", NAME, error)
            return
        self._odometry = (msg.header.frame_id, np.array([p.x, p.y, p.z]), float(np.arctan2(R[1, 0], R[0, 0])))
        self._map.set_vehicle(self._odometry[1])
        self._odometry_heard = RealTime.mark()

    def _problem(self):
        """Returns why nothing is known of the space around the vehicle; '' if it is."""
        timeout_s = self._config.timeout_s
        for mark, what in ((self._map_heard, "local map"), (self._odometry_heard, "odometry")):
            if mark is None or RealTime.elapsed_s(mark) > timeout_s:
                return "no %s for %.1f s: the sectors have no data" % (what, timeout_s)
        if self._feed.frame != self._odometry[0]:
            return "the local map is in %s and the odometry in %s: the sectors have no data" % (
                self._feed.frame, self._odometry[0])
        return ""

    def _publish(self):
        problem = self._problem()
        self._diagnostics.set_level(NodeDiagnostics.WARN if problem else NodeDiagnostics.OK, problem)
        count = self._sectors.num_horizontal + 2
        out = ObstacleSectors(n_horizontal_sectors=self._sectors.num_horizontal,
                              sectors_vertical_fov=self._sectors.vertical_fov_rad)
        out.header.frame_id, out.header.stamp = self._config.frame, rospy.Time.now()
        out.sectors = [ObstacleSectors.OBSTACLE_NO_DATA] * count
        out.sector_sensors = [ObstacleSectors.SENSOR_NONE] * count
        if not problem:
            with self._diagnostics.time("sectors"):
                self._fill(out)
        self._publisher.publish(out)

    def _fill(self, out):
        _, position, heading_rad = self._odometry
        is_known, distance_m = voxnav.obstacle_sectors(self._sectors, self._map.view(), position, heading_rad)
        for i in np.flatnonzero(is_known):
            out.sectors[i] = ObstacleSectors.OBSTACLE_NOT_DETECTED if np.isnan(distance_m[i]) else distance_m[i]
            out.sector_sensors[i] = ObstacleSectors.SENSOR_LIDAR3D


def main():
    run_node(NAME, BumperNode)
