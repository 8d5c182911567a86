#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Nodes for recordings: one that converts Livox messages, and one that publishes the mount of a played recording."""

import os
import struct
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import rosbag
import rospy
import rostest
from genpy.dynamic import generate_dynamic
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage

from node_testing import cloud_message, wait_for
from voxnav.msg import NodeDiagnostics

# The definition that livox_ros_driver and livox_ros_driver2 share.
CUSTOM_MSG = """Header header
uint64 timebase
uint32 point_num
uint8 lidar_id
uint8[3] rsvd
CustomPoint[] points
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: livox_ros_driver/CustomPoint
uint32 offset_time
float32 x
float32 y
float32 z
uint8 reflectivity
uint8 tag
uint8 line
"""


class RecordingNodesTest(unittest.TestCase):
    def test_messages_of_a_livox_driver_come_out_as_clouds(self):
        kinds = generate_dynamic("livox_ros_driver/CustomMsg", CUSTOM_MSG)
        clouds = []
        subscriber = rospy.Subscriber("livox/points", PointCloud2, clouds.append)
        publisher = rospy.Publisher("livox/lidar", kinds["livox_ros_driver/CustomMsg"], queue_size=5)
        self.addCleanup(publisher.unregister)  # a topic has one type in a process
        self.assertTrue(wait_for(lambda: publisher.get_num_connections() and subscriber.get_num_connections()))
        point = kinds["livox_ros_driver/CustomPoint"](7, 1.0, 2.0, 3.0, 40, 0, 2)
        msg = kinds["livox_ros_driver/CustomMsg"](point_num=2, rsvd=[0, 0, 0], points=[point, point])
        msg.header.stamp, msg.header.frame_id = rospy.Time(100), "livox_frame"
        publisher.publish(msg)
        self.assertTrue(wait_for(lambda: clouds), "no cloud")
        self.assertEqual((clouds[0].width, clouds[0].header.frame_id), (2, "livox_frame"))
        self.assertEqual(struct.unpack_from("<Ifff", clouds[0].data), (7, 1.0, 2.0, 3.0))

    def test_messages_of_another_type_are_refused_with_a_reason(self):
        diagnostics = []
        rospy.Subscriber("livox_cloud/diagnostics", NodeDiagnostics, diagnostics.append)
        publisher = rospy.Publisher("livox/lidar", Odometry, queue_size=5)
        self.addCleanup(publisher.unregister)
        self.assertTrue(wait_for(publisher.get_num_connections))
        publisher.publish(Odometry())
        self.assertTrue(wait_for(lambda: any("nav_msgs/Odometry" in d.message for d in diagnostics)))

    def test_the_mount_of_a_recording_is_published_below_the_given_body(self):
        links = []
        rospy.Subscriber("/tf_static", TFMessage, lambda msg: links.extend(msg.transforms))
        with tempfile.TemporaryDirectory() as folder:
            bag = self.write_bag(os.path.join(folder, "flight.bag"))
            node = subprocess.Popen(self.recording_mount(bag))
            try:
                self.assertTrue(wait_for(lambda: links), "no transform")
            finally:
                node.terminate()
                node.wait(20)
        self.assertEqual([(link.header.frame_id, link.child_frame_id) for link in links], [("uav1/fcu", "body")])

    def test_a_recording_without_a_mount_ends_the_node_with_a_status(self):
        with tempfile.TemporaryDirectory() as folder:
            bag = self.write_bag(os.path.join(folder, "flight.bag"), with_mount=False)
            self.assertEqual(subprocess.call(self.recording_mount(bag), timeout=60), 1)

    @staticmethod
    def recording_mount(bag):
        """Returns the command that starts the node."""
        programs = [os.path.join(prefix, "lib", "voxnav", "recording_mount")
                    for prefix in os.environ["CMAKE_PREFIX_PATH"].split(":")]
        return [next(program for program in programs if os.path.exists(program)), "_bags:=" + bag,
                "_body_frame:=uav1/fcu", "_uses_lidar_odometry:=false"]

    @staticmethod
    def write_bag(path, with_mount=True):
        points = np.zeros(50, np.dtype([(axis, "<f4") for axis in "xyz"]))
        points["x"] = np.arange(50)
        mount = TransformStamped(child_frame_id="lidar")
        mount.header.frame_id, mount.transform.translation.z, mount.transform.rotation.w = "body", 0.2, 1.0
        with rosbag.Bag(path, "w") as out:
            for i in range(10):
                stamp_s = 100.0 + 0.1 * i
                odometry = Odometry(child_frame_id="body")
                odometry.header.stamp, odometry.header.frame_id = rospy.Time.from_sec(stamp_s), "odom"
                odometry.pose.pose.orientation.w = 1.0
                out.write("/odom", odometry, rospy.Time.from_sec(stamp_s))
                out.write("/points", cloud_message(points, stamp_s, "lidar"), rospy.Time.from_sec(stamp_s + 0.1))
            if with_mount:
                out.write("/tf_static", TFMessage([mount]), rospy.Time.from_sec(100.0))
        return path


if __name__ == "__main__":
    rospy.init_node("recording_nodes_test")
    rostest.rosrun("voxnav", "recording_nodes", RecordingNodesTest, sys.argv)
