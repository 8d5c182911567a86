# SPDX-License-Identifier: BSD-3-Clause
"""Broadcasts where the map is in the origin of the odometry."""

import threading
import time

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from std_msgs.msg import Header

from voxnav.nodes.poses import transform_to_msg


class CorrectionBroadcast:
    """Sends the map frame as a child of the odometry origin, from start() on and once the origin has a name.

    It runs on wall time: the correction has to be on tf also while a simulated clock is stepped.
    """

    def __init__(self, map_frame, rate_hz):
        self._map_frame, self._rate_hz = map_frame, rate_hz
        self._lock, self._is_started = threading.Lock(), threading.Event()
        self._odometry_frame, self._T_O_W = "", np.eye(4)
        self._broadcaster = tf2_ros.TransformBroadcaster()
        threading.Thread(target=self._run, name="tf", daemon=True).start()

    def set(self, odometry_frame, T_O_W):
        with self._lock:
            self._odometry_frame, self._T_O_W = odometry_frame, T_O_W

    def start(self):
        self._is_started.set()

    def _run(self):
        self._is_started.wait()
        last_stamp = None
        while not rospy.is_shutdown():
            stamp = rospy.Time.now()
            with self._lock:
                header, T_O_W = Header(stamp=stamp, frame_id=self._odometry_frame), self._T_O_W
            if stamp != last_stamp and not stamp.is_zero() and header.frame_id:  # tf2 complains of a stamp sent twice
                self._broadcaster.sendTransform(TransformStamped(
                    header=header, child_frame_id=self._map_frame, transform=transform_to_msg(T_O_W)))
                last_stamp = stamp
            time.sleep(1.0 / self._rate_hz)
