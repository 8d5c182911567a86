#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The LiDAR simulator node makes of true poses the same clouds as the simulator without ROS."""

import sys
import time
import unittest

import numpy as np
import rospkg
import rospy
import rostest
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from voxnav import simulation
from voxnav.msg import Progress
from voxnav.srv import MoveVehicle

TIMEOUT_S = 30.0


class Received:
    """Collects the messages of one topic."""

    def __init__(self, topic, kind):
        self.messages = []
        self.subscriber = rospy.Subscriber(topic, kind, self.messages.append, queue_size=100)

    def is_connected(self):
        return self.subscriber.get_num_connections() > 0

    def wait(self, count):
        end = time.time() + TIMEOUT_S
        while len(self.messages) < count and time.time() < end:
            time.sleep(0.02)
        return self.messages


class LidarSimulatorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.clouds = Received("os_cloud_nodelet/points", PointCloud2)
        cls.progress = Received("progress", Progress)
        cls.markers = Received("lidar_simulator/world_markers_out", MarkerArray)
        cls.static_tf = Received("/tf_static", TFMessage)
        cls.truth = rospy.Publisher("uav_simulator/ground_truth", Odometry, queue_size=1000)
        ends = (cls.clouds, cls.progress, cls.markers, cls.static_tf)
        end = time.time() + TIMEOUT_S
        while time.time() < end and not (cls.truth.get_num_connections() and all(e.is_connected() for e in ends)):
            time.sleep(0.05)
        for i in range(102):
            cls.fly(100.0 + 0.005 * i, (0.002 * i, 0.0, 2.0))

    @classmethod
    def fly(cls, stamp_s, position):
        msg = Odometry()
        msg.header.stamp = rospy.Time.from_sec(stamp_s)
        msg.header.frame_id = "uav1/world_origin"
        msg.pose.pose.position.x, msg.pose.pose.position.y, msg.pose.pose.position.z = position
        msg.pose.pose.orientation.w = 1.0
        cls.truth.publish(msg)

    def test_clouds_come_once_per_turn_stamped_with_its_start(self):
        clouds = self.clouds.wait(5)
        stamps = [cloud.header.stamp.to_sec() for cloud in clouds[:5]]
        np.testing.assert_allclose(stamps, 100.0 + 0.1 * np.arange(5), atol=1e-6)
        self.assertEqual(clouds[0].header.frame_id, "uav1/os_sensor")
        self.assertEqual((clouds[0].height, clouds[0].width, clouds[0].point_step), (16, 1024, 48))
        self.assertEqual(len(clouds[0].data), 16 * 1024 * 48)

    def test_progress_follows_every_cloud(self):
        progress = self.progress.wait(5)
        self.assertEqual({report.node for report in progress}, {"lidar_simulator"})
        self.assertAlmostEqual(progress[4].stamp.to_sec(), 100.4, places=6)

    def test_cloud_is_what_the_sensor_sees_without_ros(self):
        cloud = self.clouds.wait(2)[1]
        path = rospkg.RosPack().get_path("voxnav") + "/worlds/firetruck.yaml"
        lidar = simulation.Lidar(model="os1-16", seed=3)
        mount = simulation.pose(0.0, 0.0, 0.15)
        start, end = (simulation.pose(x, 0.0, 2.0) @ mount for x in (0.04, 0.08))
        expected = lidar.scan(simulation.World(path, seed=3), start, end, scan_index=1001)
        points = np.frombuffer(cloud.data, np.float32).reshape(16, 1024, 12)
        np.testing.assert_allclose(points[..., :3], expected.organised[..., :3], atol=1e-3)

    def test_mount_is_a_child_of_the_body(self):
        transform = self.static_tf.wait(1)[0].transforms[0]
        self.assertEqual((transform.header.frame_id, transform.child_frame_id), ("uav1/fcu", "uav1/os_sensor"))
        self.assertAlmostEqual(transform.transform.translation.z, 0.15)

    def test_vehicle_moves_by_service_and_in_rviz(self):
        self.markers.wait(1)
        move = rospy.ServiceProxy("lidar_simulator/move_vehicle", MoveVehicle)
        self.assertTrue(move(5.0, 6.0, 0.0).success)
        vehicle = [marker for marker in self.markers.wait(2)[-1].markers if marker.ns == "vehicle"]
        self.assertEqual((vehicle[0].pose.position.x, vehicle[0].pose.position.y), (5.0, 6.0))
        self.assertEqual(vehicle[0].header.frame_id, "uav1/world_origin")
        refused = move(1e6, 0.0, 0.0)
        self.assertFalse(refused.success)
        self.assertIn("no ground", refused.message)


if __name__ == "__main__":
    rospy.init_node("lidar_simulator_test")
    rostest.rosrun("voxnav", "lidar_simulator", LidarSimulatorTest, sys.argv)
