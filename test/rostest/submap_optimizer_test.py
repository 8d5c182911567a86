#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The submap_optimizer node takes submaps from the integrator, closes a loop, and publishes its results."""

import os
import sys
import tempfile
import threading
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from mrs_msgs.srv import String
from nav_msgs.msg import Path
from std_msgs.msg import Header
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from voxnav import pose_from_yaw
from voxnav.msg import FinishedSubmap, LoopClosure, NodeDiagnostics, OptimizerReport, Progress, SubmapPoses
from voxnav.nodes.poses import pose_from_msg, pose_to_msg
from voxnav.srv import GetSubmaps, GetSubmapsResponse

NODE = "/uav1/submap_optimizer/"
PERIOD_S, COUNT = 10.0, 8


def body_at(t):
    angle = 2.0 * np.pi * t / (PERIOD_S * COUNT)
    return pose_from_yaw([20.0 * np.sin(angle), 20.0 * (1.0 - np.cos(angle)), 5.0], angle)


def odometry_at(t):
    return pose_from_yaw([0.02 * t, 0.01 * t, 0.0], 0.0003 * t) @ body_at(t)


def submap(k):
    stamps = 100.0 + PERIOD_S * k + np.linspace(0.0, PERIOD_S, 6)
    T_O_S = odometry_at(stamps[0] - 100.0)
    out = FinishedSubmap(header=Header(stamp=rospy.Time.from_sec(stamps[-1]), frame_id="uav1/odom"), submap_id=k,
                         start=rospy.Time.from_sec(stamps[0]), T_O_S=pose_to_msg(T_O_S))
    out.pose_stamps = [rospy.Time.from_sec(s) for s in stamps]
    out.T_S_B = [pose_to_msg(np.linalg.inv(T_O_S) @ odometry_at(s - 100.0)) for s in stamps]
    return out


class Latest:
    """Waits for a message that fulfils a condition."""

    def __init__(self, topic, kind):
        self._changed, self._messages = threading.Condition(), []
        rospy.Subscriber(topic, kind, self._on, queue_size=50)

    def _on(self, msg):
        with self._changed:
            self._messages.append(msg)
            self._changed.notify_all()

    def wait(self, condition=lambda msg: True, timeout_s=20.0):
        with self._changed:
            found = self._changed.wait_for(lambda: any(condition(m) for m in self._messages), timeout_s)
            return next(m for m in reversed(self._messages) if condition(m)) if found else None


class SubmapOptimizerTest(unittest.TestCase):
    def test_node(self):
        # An integrator that already has submaps is simulated: the node gets them once, whichever starts first.
        rospy.Service("/uav1/submap_integrator/get_submaps", GetSubmaps,
                      lambda _: GetSubmapsResponse(True, "", [submap(0), submap(1)]))
        poses, report = Latest(NODE + "submap_poses_out", SubmapPoses), Latest(NODE + "report_out", OptimizerReport)
        path, markers = Latest(NODE + "trajectory_out", Path), Latest(NODE + "graph_markers_out", MarkerArray)
        diagnostics, progress = Latest(NODE + "diagnostics", NodeDiagnostics), Latest("/uav1/progress", Progress)
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        first = buffer.lookup_transform("uav1/odom", "uav1/voxnav_map", rospy.Time(0), rospy.Duration(10.0))
        self.assertEqual(first.header.frame_id, "uav1/odom")

        submaps = rospy.Publisher("/uav1/submap_integrator/submap", FinishedSubmap, queue_size=20)
        loops = rospy.Publisher(NODE + "loop_closure_in", LoopClosure, queue_size=20)
        while submaps.get_num_connections() == 0 or loops.get_num_connections() == 0:
            rospy.sleep(0.05)
        for k in range(COUNT):
            submaps.publish(submap(k))
        self.assertIsNotNone(poses.wait(lambda m: len(m.submap_ids) == COUNT))
        self.assertIsNotNone(progress.wait(lambda m: m.stamp == submap(COUNT - 1).header.stamp))

        t_a, t_b = 1.0, PERIOD_S * COUNT - 1.0
        loop = LoopClosure(stamp_a=rospy.Time.from_sec(100.0 + t_a), stamp_b=rospy.Time.from_sec(100.0 + t_b),
                           T_A_B=pose_to_msg(np.linalg.inv(body_at(t_a)) @ body_at(t_b)))
        loop.covariance = (np.eye(6) * 1e-4).ravel().tolist()
        loops.publish(loop)
        self.assertIsNotNone(report.wait(lambda m: m.num_constraints[m.kinds.index("loop")] == 1))
        self.check_newest_stays(poses.wait(lambda m: m.revision == report.wait().revision))
        self.assertGreater(len(path.wait().poses), COUNT)
        self.assertEqual({m.ns for m in markers.wait().markers}, {"submaps", "odometry", "registration", "loop"})
        self.assertEqual(diagnostics.wait().node, "submap_optimizer")
        self.check_services()

    def check_newest_stays(self, msg):
        T_W_S = pose_from_msg(msg.T_W_S[list(msg.submap_ids).index(COUNT - 1)])
        T_O_S = pose_from_msg(submap(COUNT - 1).T_O_S)
        np.testing.assert_allclose(pose_from_msg(msg.T_W_O) @ T_O_S, T_W_S, atol=1e-6)
        self.assertGreater(np.linalg.norm(pose_from_msg(msg.T_W_O)[:3, 3]), 0.1)
        self.assertEqual(msg.header.frame_id, "uav1/voxnav_map")

    def check_services(self):
        answer = rospy.ServiceProxy(NODE + "optimize_in", Trigger)()
        self.assertTrue(answer.success, answer.message)
        disable = rospy.ServiceProxy(NODE + "disable_kind_in", String)
        self.assertTrue(disable("loop").success)
        self.assertIn("kind must be", disable("magic").message)
        save = rospy.ServiceProxy(NODE + "save_g2o_in", String)
        with tempfile.TemporaryDirectory() as folder:
            target = os.path.join(folder, "graph.g2o")
            self.assertTrue(save(target).success)
            with open(target) as saved:
                self.assertEqual(sum(line.startswith("VERTEX") for line in saved), COUNT)
        self.assertFalse(save("/nowhere/graph.g2o").success)


if __name__ == "__main__":
    rospy.init_node("submap_optimizer_test")
    rostest.rosrun("voxnav", "submap_optimizer_test", SubmapOptimizerTest, sys.argv)
