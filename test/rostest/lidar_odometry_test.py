#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The LiDAR odometry node tracks a body in a room, and survives bad scans, a clock that jumps back, and resets."""

import sys
import time
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, PointCloud2, PointField
from std_srvs.srv import Empty, Trigger
from tf2_msgs.msg import TFMessage

from node_testing import wait_for
from voxnav.msg import NodeDiagnostics, OdometryQuality, Progress

ROOM_M = np.array([8.0, 6.0, 2.5])
LIDAR_HEIGHT_M = 0.3


def room_points(seed, body, count=8000):
    """Returns random points on the walls of a room in the frame of the LiDAR, which is above the body."""
    rng = np.random.RandomState(seed)
    points = rng.uniform(-1, 1, (count, 3)) * ROOM_M
    axis, rows = rng.randint(0, 3, count), np.arange(count)
    points[rows, axis] = np.sign(points[rows, axis]) * ROOM_M[axis]
    return (points - body - [0, 0, LIDAR_HEIGHT_M]).astype(np.float32)


def cloud_msg(points, stamp_s, frame_id="uav1/os_sensor"):
    msg = PointCloud2(height=1, width=len(points), point_step=12, row_step=12 * len(points), data=points.tobytes())
    msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(stamp_s), frame_id
    msg.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyz")]
    return msg


class LidarOdometryTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.odom, cls.quality, cls.progress, cls.diagnostics, cls.tf = [], [], [], [], []
        subscribers = [rospy.Subscriber("lidar_odometry/odom_out", Odometry, cls.odom.append),
                       rospy.Subscriber("lidar_odometry/quality_out", OdometryQuality, cls.quality.append),
                       rospy.Subscriber("lidar_odometry/diagnostics_out", NodeDiagnostics, cls.diagnostics.append),
                       rospy.Subscriber("progress", Progress, cls.progress.append),
                       rospy.Subscriber("/tf", TFMessage, lambda m: cls.tf.extend(m.transforms))]
        cls.points = rospy.Publisher("lidar_odometry/points_in", PointCloud2, queue_size=10)
        cls.imu = rospy.Publisher("lidar_odometry/imu_in", Imu, queue_size=1000)
        wait_for(lambda: cls.points.get_num_connections() and cls.imu.get_num_connections() and
                 all(s.get_num_connections() for s in subscribers))
        cls.mount = tf2_ros.StaticTransformBroadcaster()

    def send_mount(self):
        transform = TransformStamped(child_frame_id="uav1/os_sensor")
        transform.header.frame_id = "uav1/fcu"
        transform.transform.translation.z = LIDAR_HEIGHT_M
        transform.transform.rotation.w = 1.0
        self.mount.sendTransform(transform)

    def send_imu(self, from_s, to_s):
        for stamp_s in np.arange(from_s, to_s, 0.005):
            msg = Imu()
            msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(stamp_s), "uav1/fcu"
            msg.linear_acceleration.z = 9.81
            self.imu.publish(msg)

    def send(self, msg, is_taken=True):
        """Publishes a cloud and waits for the progress of the node, and if it is used for odometry and quality."""
        done = len(self.progress)
        self.points.publish(msg)
        self.assertTrue(wait_for(lambda: len(self.progress) > done), "no progress after a cloud")
        self.assertEqual(self.progress[-1].stamp, msg.header.stamp)
        stamp = msg.header.stamp
        if is_taken:
            self.assertTrue(wait_for(lambda: self.has_answered(stamp)), "no odometry for a cloud")

    def has_answered(self, stamp):
        return all(said and said[-1].header.stamp == stamp for said in (self.odom, self.quality))

    def fly(self, first, last, start_s):
        for i in range(first, last):
            stamp_s = start_s + 0.1 * i
            self.send_imu(stamp_s - 0.1, stamp_s + 0.005)
            self.send(cloud_msg(room_points(i, np.array([0.05 * i, 0.0, 0.0])), stamp_s))

    def find_mount(self, from_s):
        """Publishes clouds from the place where the flight begins until the mount has reached the node."""
        self.send_imu(from_s - 0.1, from_s - 0.006)
        for i in range(80):
            stamp_s = from_s + 0.01 * i
            self.send_imu(stamp_s - 0.005, stamp_s + 0.004)
            self.send(cloud_msg(room_points(0, np.zeros(3)), stamp_s), is_taken=False)
            end = time.time() + 0.25
            while time.time() < end:
                if self.odom:
                    return
                time.sleep(0.01)
        said = {diagnostics.message for diagnostics in self.diagnostics}
        self.fail("no pose after %d clouds, %d listen to the mount; the node said %s" % (
            len(self.progress), self.mount.pub_tf.get_num_connections(), sorted(said)))

    def said(self, text):
        return wait_for(lambda: any(text in d.message for d in self.diagnostics))

    def position(self):
        p = self.odom[-1].pose.pose.position
        return np.array([p.x, p.y, p.z])

    def test_a_flight_with_troubles(self):
        # 1. The node publishes no pose before the mount of the LiDAR is known.
        self.send(cloud_msg(room_points(99, np.zeros(3)), 99.0), is_taken=False)
        self.assertTrue(self.said("the LiDAR's mounting is unknown"))

        # 2. The node tracks the body rather than the LiDAR, and publishes its origin as a child of the body in tf.
        self.send_mount()
        self.find_mount(99.1)
        self.fly(0, 12, 100.0)
        self.assertNotIn(99.0, [odom.header.stamp.to_sec() for odom in self.odom])
        self.assertEqual(len({odom.header.stamp for odom in self.odom if odom.header.stamp.to_sec() > 99.95}), 12)
        self.assertEqual(self.odom[-1].header.frame_id, "uav1/slam_origin")
        self.assertEqual(self.odom[-1].child_frame_id, "uav1/fcu")
        self.assertEqual(self.quality[-1].state, OdometryQuality.TRACKING, self.quality[-1].reason)
        np.testing.assert_allclose(self.position(), [0.55, 0.0, 0.0], atol=0.05)
        np.testing.assert_allclose(self.odom[-1].twist.twist.linear.x, 0.5, atol=0.2)
        mine = [t for t in self.tf if t.child_frame_id == "uav1/slam_origin"][-1]
        self.assertEqual(mine.header.frame_id, "uav1/fcu")
        self.assertNotIn("uav1/fcu", [t.child_frame_id for t in self.tf])
        tracked_covariance = self.odom[-1].pose.covariance[0]

        # 3. Through scans that are empty, all NaN or of another place, odometry coasts with a reason and does not jump.
        rng = np.random.RandomState(5)
        bad = [np.zeros((0, 3), np.float32), np.full((5000, 3), np.nan, np.float32),
               rng.uniform(-50, 50, (8000, 3)).astype(np.float32)]
        for i, points in enumerate(bad):
            self.send_imu(101.1 + 0.1 * i, 101.205 + 0.1 * i)
            self.send(cloud_msg(points, 101.2 + 0.1 * i))
            self.assertEqual(self.quality[-1].state, OdometryQuality.COASTING)
            self.assertTrue(self.quality[-1].reason)
        np.testing.assert_allclose(self.position(), [0.70, 0.0, 0.0], atol=0.15)
        self.assertGreater(self.odom[-1].pose.covariance[0], 2 * tracked_covariance)

        # 4. Clouds with wrong field types or frames are refused, and the field or frame is named.
        had = len(self.odom)
        wrong = cloud_msg(room_points(1, np.zeros(3)), 101.45)
        wrong.fields[0].datatype = PointField.INT32
        self.send(wrong, is_taken=False)
        self.assertTrue(self.said("field 'x' is int32"))
        self.send(cloud_msg(room_points(1, np.zeros(3)), 101.46, "uav1/other"), is_taken=False)
        self.assertTrue(self.said("is in frame 'uav1/other'"))

        # 5. With scans of the room odometry tracks again; the refused clouds have given no odometry.
        self.fly(15, 20, 100.0)
        self.assertEqual(len(self.odom), had + 5)
        self.assertEqual(self.quality[-1].state, OdometryQuality.TRACKING, self.quality[-1].reason)
        np.testing.assert_allclose(self.position(), [0.95, 0.0, 0.0], atol=0.05)

        # 6. A clock that jumps back, once a third cloud confirms it, changes the stamps but not the pose.
        had = len(self.odom)
        self.send_imu(19.6, 20.005)
        for stamp_s in (19.8, 19.9):
            self.send(cloud_msg(room_points(50, np.array([0.95, 0.0, 0.0])), stamp_s), is_taken=False)
        self.assertTrue(self.said("on another clock"))
        self.send(cloud_msg(room_points(50, np.array([0.95, 0.0, 0.0])), 20.0))
        self.assertEqual(len(self.odom), had + 1)
        np.testing.assert_allclose(self.position(), [0.95, 0.0, 0.0], atol=0.1)
        self.assertAlmostEqual(self.odom[-1].header.stamp.to_sec(), 20.0, places=6)

        # 7. Both services for a reset work.
        self.assertTrue(rospy.ServiceProxy("lidar_odometry/reset", Trigger)().success)
        rospy.ServiceProxy("lidar_odometry/reset_odom", Empty)()
        self.send_imu(20.1, 20.305)
        self.send(cloud_msg(room_points(51, np.zeros(3)), 20.3))
        np.testing.assert_allclose(self.position(), [0.0, 0.0, 0.0], atol=1e-6)
        self.assertEqual(self.quality[-1].state, OdometryQuality.INITIALIZING)


if __name__ == "__main__":
    rospy.init_node("lidar_odometry_test")
    rostest.rosrun("voxnav", "lidar_odometry", LidarOdometryTest, sys.argv)
