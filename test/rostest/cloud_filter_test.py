#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The cloud filter node filters clouds in the layouts of drivers, and answers bad input with a reason."""

import sys
import unittest

import numpy as np
import rospy
import rostest
from mrs_msgs.msg import ControlManagerDiagnostics
from sensor_msgs.msg import PointCloud2, PointField

from std_srvs.srv import Trigger

from node_testing import cloud_message, wait_for
from voxnav.msg import NodeDiagnostics, Progress

GAZEBO = np.dtype({"names": ["x", "y", "z", "intensity", "ring", "range", "t", "reflectivity", "ambient"],
                   "formats": ["<f4", "<f4", "<f4", "<f4", "u1", "<u4", "<u4", "<u2", "<u2"],
                   "offsets": [0, 4, 8, 12, 16, 17, 21, 25, 27], "itemsize": 29})


def gazebo_cloud(height=4, width=8):
    """Returns a cloud in which every point is 5 m ahead and strong enough to be kept."""
    points = np.zeros((height, width), GAZEBO)
    points["x"], points["intensity"], points["t"] = 5.0, 100.0, 7000
    return points


class CloudFilterTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.points, cls.ghosts, cls.diagnostics, cls.progress = [], [], [], []
        subscribers = [rospy.Subscriber("cloud_filter/points_out", PointCloud2, cls.points.append),
                       rospy.Subscriber("cloud_filter/rejected_out", PointCloud2, cls.ghosts.append),
                       rospy.Subscriber("cloud_filter/diagnostics_out", NodeDiagnostics, cls.diagnostics.append),
                       rospy.Subscriber("progress", Progress, cls.progress.append)]
        cls.cloud = rospy.Publisher("cloud_filter/cloud_in", PointCloud2, queue_size=10)
        cls.control = rospy.Publisher("cloud_filter/control_diagnostics_in", ControlManagerDiagnostics, queue_size=10)
        cls.learn = rospy.ServiceProxy("cloud_filter/learn_body_in", Trigger)
        wait_for(lambda: cls.cloud.get_num_connections() and cls.control.get_num_connections() and
                 all(s.get_num_connections() for s in subscribers))

    def send(self, msg):
        """Publishes a cloud and waits until the node has filtered or refused it."""
        done = len(self.progress)
        self.cloud.publish(msg)
        self.assertTrue(wait_for(lambda: len(self.progress) > done), "no progress after a cloud")
        self.assertEqual(self.progress[-1].stamp, msg.header.stamp)

    def send_good(self, msg):
        """Publishes a cloud and returns its output, which must be the only one since the last filtered cloud."""
        had = len(self.points)
        self.send(msg)
        self.assertTrue(wait_for(lambda: len(self.points) > had), "no output")
        self.assertEqual([out.header.stamp for out in self.points[had:]], [msg.header.stamp])
        return self.points[-1]

    def refuse(self, msg, text):
        self.send(msg)
        self.assertTrue(wait_for(lambda: any(text in d.message for d in self.diagnostics)),
                        "diagnostics never said: " + text)
        said = [d for d in self.diagnostics if text in d.message][-1]
        self.assertEqual(said.level, NodeDiagnostics.ERROR)
        self.assertIn("/uav1/cloud_filter/cloud_in", said.message)
        self.send_good(cloud_message(gazebo_cloud(), 13.0))

    def test_packed_gazebo_cloud_comes_out_filtered(self):
        points = gazebo_cloud()
        points["x"][0, :3] = 0.0
        points["intensity"][1, 0] = 3.0
        out = self.send_good(cloud_message(points, 10.0))
        self.assertEqual((out.height, out.width, out.point_step), (1, 28, 32))
        self.assertEqual([f.name for f in out.fields][:5], ["x", "y", "z", "intensity", "t"])
        self.assertEqual((out.header.frame_id, out.header.stamp.to_sec()), ("uav1/os_sensor", 10.0))
        rows = np.frombuffer(out.data, np.float32).reshape(-1, 8)
        np.testing.assert_array_equal(rows[:, 0], 5.0)
        self.assertTrue(wait_for(lambda: any(g.width == 1 for g in self.ghosts)))

    def test_empty_and_all_nan_clouds_pass_as_empty(self):
        self.assertEqual(self.send_good(cloud_message(gazebo_cloud(1, 0), 11.0)).width, 0)
        points = gazebo_cloud()
        points["x"] = np.nan
        self.assertEqual(self.send_good(cloud_message(points, 11.1)).width, 0)
        self.assertTrue(wait_for(lambda: any("was kept: 32 nan" in d.message for d in self.diagnostics)))

    def test_beams_without_return_are_rows_without_coordinates(self):
        elevation = np.linspace(0.7, -0.7, 32)[:, None]
        azimuth = -2.0 * np.pi * np.arange(256)[None, :] / 256
        points = np.zeros((32, 256), GAZEBO)
        points["x"], points["y"] = 9.0 * np.cos(elevation) * np.cos(azimuth), 9.0 * np.cos(elevation) * np.sin(azimuth)
        points["z"], points["intensity"] = 9.0 * np.sin(elevation), 100.0
        points["x"][:16], points["y"][:16], points["z"][:16] = 0.0, 0.0, 0.0  # beams into the sky have no return
        for i in range(8):  # the node learns from returns where a beam points
            out = self.send_good(cloud_message(points, 20.0 + 0.1 * i))
        self.assertEqual([f.name for f in out.fields], ["x", "y", "z", "intensity", "t", "beam_x", "beam_y", "beam_z"])
        rows = np.frombuffer(out.data, np.float32).reshape(-1, out.point_step // 4)
        is_beam = np.isnan(rows[:, 0])
        self.assertEqual(is_beam.sum() + 16 * 256, len(rows))
        self.assertGreater(is_beam.sum(), 100)
        self.assertFalse(out.is_dense)
        np.testing.assert_array_equal(rows[~is_beam, 5:], 0.0)
        np.testing.assert_allclose(np.linalg.norm(rows[is_beam, 5:], axis=1), 1.0, atol=1e-5)
        self.assertGreater(rows[is_beam, 7].min(), -0.05)  # no open beam points down

    def test_wrong_field_types_are_named(self):
        msg = cloud_message(gazebo_cloud(), 12.0)
        msg.fields[1].datatype = PointField.INT32
        self.refuse(msg, "field 'y' is int32, must be float32 or float64")

    def test_missing_fields_are_named(self):
        msg = cloud_message(gazebo_cloud(), 12.1)
        del msg.fields[2]
        self.refuse(msg, "field 'z' is missing")

    def test_short_data_is_refused(self):
        msg = cloud_message(gazebo_cloud(), 12.2)
        msg.data = msg.data[:100]
        self.refuse(msg, "data has 100 bytes")

    def ask_to_learn(self, is_flying, text):
        """Publishes the flight state again and again, as the control manager does, until the service knows it."""
        def answer():
            self.control.publish(ControlManagerDiagnostics(flying_normally=is_flying))
            self.last_answer = self.learn()
            return text in self.last_answer.message
        self.assertTrue(wait_for(answer), self.last_answer.message)
        return self.last_answer.success

    def test_own_body_is_learnt_on_the_ground_only(self):
        self.assertFalse(self.ask_to_learn(True, "the UAV flies"))
        near = gazebo_cloud()
        near["x"][0, :] = 0.9
        self.assertEqual(self.send_good(cloud_message(near, 14.0)).width, 32)
        self.assertTrue(self.ask_to_learn(False, "learning from the next 3 clouds"))
        for i in range(3):
            self.assertEqual(self.send_good(cloud_message(near, 14.1 + 0.1 * i)).width, 32)
        self.assertEqual(self.send_good(cloud_message(near, 15.0)).width, 24)

    def test_clouds_after_a_clock_that_fell_back_still_come_out(self):
        self.assertEqual(self.send_good(cloud_message(gazebo_cloud(), 1000.0)).width, 32)
        self.assertEqual(self.send_good(cloud_message(gazebo_cloud(), 5.0)).width, 32)

        def jumps():
            d = self.diagnostics[-1] if self.diagnostics else NodeDiagnostics()
            return dict(zip(d.counter_names, d.counter_values)).get("time_jumps_back", 0)
        self.assertTrue(wait_for(lambda: jumps() >= 1))


if __name__ == "__main__":
    rospy.init_node("cloud_filter_test")
    rostest.rosrun("voxnav", "cloud_filter", CloudFilterTest, sys.argv)
