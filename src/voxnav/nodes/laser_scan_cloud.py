# SPDX-License-Identifier: BSD-3-Clause
"""Publishes the scans of a 2-D scanner as clouds, for a cloud filter."""

import numpy as np
import rospy
from sensor_msgs.msg import LaserScan, PointCloud2

from voxnav.msg import NodeDiagnostics
from voxnav.nodes.clouds import points_to_msg
from voxnav.nodes.node_base import Diagnostics, run_node

MAX_BEAMS = 100000
# A scan whose beams span more than this has an angle_increment of another unit.
MAX_SPAN_RAD = 2.0 * np.pi + 0.1


def cloud_of(scan):
    """Returns the PointCloud2 of a LaserScan: one point for each beam, NaN for a beam without a range that is valid.

    Raises ValueError saying what is wrong with the scan.
    """
    ranges = np.asarray(scan.ranges, dtype=np.float32)
    if not 0 < len(ranges) <= MAX_BEAMS:
        raise ValueError("it has %d beams" % len(ranges))
    angles = (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)
    if not np.isfinite(angles).all():
        raise ValueError("its angles or limits are not finite")
    if abs(scan.angle_increment) * (len(ranges) - 1) > MAX_SPAN_RAD:
        raise ValueError("its beams span more than a turn: angle_increment is %g rad" % scan.angle_increment)
    is_valid = np.isfinite(ranges) & (ranges >= scan.range_min) & (ranges <= scan.range_max)
    azimuths = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    kept = np.where(is_valid, ranges, np.nan)
    points = np.stack([kept * np.cos(azimuths), kept * np.sin(azimuths), 0.0 * kept], axis=1)
    cloud = points_to_msg(points, scan.header)
    cloud.is_dense = False
    return cloud


class LaserScanCloud:
    """The node."""

    def __init__(self):
        self._diagnostics = Diagnostics(rospy.get_name().split("/")[-1])
        self._num_refused = 0
        self._clouds = rospy.Publisher("~cloud_out", PointCloud2, queue_size=5)
        self._subscriber = rospy.Subscriber("~scan_in", LaserScan, self._on_scan, queue_size=5, tcp_nodelay=True)

    def _on_scan(self, scan):
        try:
            with self._diagnostics.time("convert"):
                self._clouds.publish(cloud_of(scan))
            self._diagnostics.set_level(NodeDiagnostics.OK)
        except ValueError as error:
            self._num_refused += 1
            self._diagnostics.set_counter("scans_refused", self._num_refused)
            self._diagnostics.set_level(NodeDiagnostics.ERROR, "scan refused: %s" % error)
            rospy.logerr_throttle(5.0, "scan on %s refused: %s", self._subscriber.resolved_name, error)


def main():
    run_node("laser_scan_cloud", LaserScanCloud)
