#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The local mapper node makes map updates and handovers from clouds and tf, and answers bad input with a reason."""

import os
import sys
import tempfile
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import TransformStamped
from mrs_msgs.srv import String
from octomap_msgs.msg import Octomap
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from node_testing import cloud_message, wait_for
import voxnav
from voxnav.msg import GridUpdate, Handover, NodeDiagnostics, Progress
from voxnav.srv import GetGrid

POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("t", "<u4")])


def wall():
    """Returns points on a wall 5.1 m ahead of the sensor."""
    y, z = np.meshgrid(np.arange(-2.0, 2.0, 0.05), np.arange(-1.0, 1.0, 0.05))
    points = np.zeros(y.size, POINT)
    points["x"], points["y"], points["z"] = 5.1, y.ravel(), z.ravel()
    return points


def transform(parent, child, stamp_s, x):
    out = TransformStamped()
    out.header.stamp, out.header.frame_id, out.child_frame_id = rospy.Time.from_sec(stamp_s), parent, child
    out.transform.translation.x, out.transform.rotation.w = x, 1.0
    return out


def mirror(updates):
    """Returns the grid that a listener builds from all updates."""
    blocks = {}
    for update in updates:
        if update.is_snapshot:
            blocks = {}
        size = 1024
        for i in range(len(update.block_indices) // 3):
            blocks[tuple(update.block_indices[3 * i:3 * i + 3])] = bytes(update.states[size * i:size * (i + 1)])
        for i in range(len(update.removed_block_indices) // 3):
            blocks.pop(tuple(update.removed_block_indices[3 * i:3 * i + 3]), None)
    return blocks


class LocalMapperTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.updates, cls.handovers, cls.diagnostics, cls.progress, cls.octomaps = [], [], [], [], []
        subscribers = [rospy.Subscriber("local_mapper/map_out", GridUpdate, cls.updates.append),
                       rospy.Subscriber("local_mapper/handover_out", Handover, cls.handovers.append),
                       rospy.Subscriber("local_mapper/octomap_out", Octomap, cls.octomaps.append),
                       rospy.Subscriber("local_mapper/diagnostics_out", NodeDiagnostics, cls.diagnostics.append),
                       rospy.Subscriber("progress", Progress, cls.progress.append)]
        cls.cloud = rospy.Publisher("local_mapper/points_in", PointCloud2, queue_size=10)
        cls.tf = rospy.Publisher("/tf", TFMessage, queue_size=100)
        wait_for(lambda: cls.cloud.get_num_connections() and cls.tf.get_num_connections() and
                 all(s.get_num_connections() for s in subscribers))
        cls.now = 1000.0

    def move_time(self, seconds):
        type(self).now += seconds
        return self.now

    def send_tf(self, stamp_s, x=0.0):
        self.tf.publish(TFMessage([transform("uav1/world_origin", "uav1/fcu", stamp_s, x),
                                   transform("uav1/fcu", "uav1/os_sensor", stamp_s, 0.0)]))

    def scan(self, x=0.0, points=None):
        self.scan_at(self.move_time(0.1), x, points)

    def scan_at(self, stamp_s, x=0.0, points=None):
        self.send_tf(stamp_s - 0.02, x)
        self.send_tf(stamp_s + 0.02, x)
        self.publish(cloud_message(wall() if points is None else points, stamp_s))

    def publish(self, msg):
        done = len(self.progress)
        self.cloud.publish(msg)
        self.assertTrue(wait_for(lambda: len(self.progress) > done), "no progress after a cloud")

    def expect_message(self, text):
        self.assertTrue(wait_for(lambda: any(text in d.message for d in self.diagnostics)),
                        "diagnostics never said: %s, but %s" % (text, sorted({d.message for d in self.diagnostics})))

    def test_deltas_rebuild_the_map_that_the_service_gives(self):
        for _ in range(5):
            self.scan()
        answer = rospy.ServiceProxy("local_mapper/get_map_in", GetGrid)()
        self.assertTrue(answer.success)
        self.assertTrue(mirror([answer.grid]))
        self.assertTrue(wait_for(lambda: self.updates and self.updates[-1].sequence == answer.grid.sequence))
        self.assertEqual(mirror(self.updates), mirror([answer.grid]))
        self.assertEqual(answer.grid.header.frame_id, "uav1/world_origin")
        self.assertEqual([u.sequence for u in self.updates],
                         list(range(self.updates[0].sequence, self.updates[0].sequence + len(self.updates))))
        self.assertTrue(wait_for(lambda: self.octomaps))
        self.assertEqual(self.octomaps[-1].id, "OcTree")

    def test_a_submap_is_handed_over_after_its_period(self):
        had = len(self.handovers)
        for _ in range(14):
            self.scan()
        self.assertTrue(wait_for(lambda: len(self.handovers) > had))
        handover = self.handovers[-1]
        self.assertTrue(handover.is_final)
        content = voxnav.MapContent.from_bytes(bytes(handover.content))
        points = content.occupied_points()
        self.assertGreater(len(points), 30)
        np.testing.assert_allclose(points[:, 0], 5.1, atol=0.01)
        self.assertEqual(len(handover.pose_stamps), len(handover.T_S_B))

    def test_a_scan_without_tf_is_dropped_and_said_so(self):
        self.publish(cloud_message(wall(), self.move_time(5.0)))
        self.expect_message("no pose within")
        self.scan()

    def test_bad_clouds_are_dropped_and_said_so(self):
        msg = cloud_message(wall(), self.move_time(0.1))
        msg.data = msg.data[:-5]
        self.publish(msg)
        self.expect_message("scan dropped")
        empty = np.zeros(0, POINT)
        self.scan(points=empty)

    def test_a_jump_hands_over_and_clears(self):
        for _ in range(4):
            self.scan()
        had = len(self.handovers)
        self.scan(x=500.0)
        self.assertTrue(wait_for(lambda: len(self.handovers) > had))
        self.assertEqual(self.handovers[-1].reason, "odometry")
        self.expect_message("jumped by")
        self.scan(x=0.0)

    def counter(self, name):
        """Returns a counter of the last diagnostics, or None."""
        last = self.diagnostics[-1] if self.diagnostics else NodeDiagnostics()
        return dict(zip(last.counter_names, last.counter_values)).get(name)

    def num_closed_by_odometry(self):
        return sum(handover.reason == "odometry" for handover in self.handovers)

    def test_late_clouds_are_dropped_and_only_a_lasting_jump_back_clears(self):
        for _ in range(16):  # these scans also publish the poses for the late clouds below
            self.scan()
        had, now = self.num_closed_by_odometry(), self.now
        for late_s in (now, now - 0.15, now - 1.4):  # repeated, a little late, and very late
            self.publish(cloud_message(wall(), late_s))
            self.scan()
        self.expect_message("its stamp is not newer")
        self.assertTrue(wait_for(lambda: self.counter("scans_late") == 3))
        self.assertNotEqual(mirror([rospy.ServiceProxy("local_mapper/get_map_in", GetGrid)().grid]), {})
        self.assertEqual(self.num_closed_by_odometry(), had)
        for i in range(4):
            self.publish(cloud_message(wall(), now - 1.4 + 0.1 * i))
        self.expect_message("time jumped back")
        self.assertTrue(wait_for(lambda: self.num_closed_by_odometry() == had + 1))
        self.scan()  # goes back to the clock of the other tests

    def test_save_load_and_reset(self):
        for _ in range(4):
            self.scan()
        path = os.path.join(tempfile.mkdtemp(), "map.vxlm")
        self.assertTrue(rospy.ServiceProxy("local_mapper/save_in", String)(path).success)
        self.assertTrue(rospy.ServiceProxy("local_mapper/reset_in", Trigger)().success)
        answer = rospy.ServiceProxy("local_mapper/get_map_in", GetGrid)()
        self.assertEqual(mirror([answer.grid]), {})
        self.assertTrue(rospy.ServiceProxy("local_mapper/load_in", String)(path).success)
        self.assertNotEqual(mirror([rospy.ServiceProxy("local_mapper/get_map_in", GetGrid)().grid]), {})
        refused = rospy.ServiceProxy("local_mapper/load_in", String)("/nonexistent")
        self.assertFalse(refused.success)
        self.assertIn("/nonexistent", refused.message)


if __name__ == "__main__":
    rospy.init_node("local_mapper_test")
    rostest.rosrun("voxnav", "local_mapper", LocalMapperTest, sys.argv)
