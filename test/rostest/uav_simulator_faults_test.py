#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Faults of the UAV simulator node show as on the MRS system: resets, refusals, slow services, lost messages."""

import sys
import threading
import time
import unittest

import numpy as np
import rospy
import rostest
from mrs_msgs.msg import ControlManagerDiagnostics, Path, Reference, UavState
from mrs_msgs.srv import GetPathSrv, Vec4
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

TIMEOUT_S = 60.0


def wait_for(condition, what):
    end = time.monotonic() + TIMEOUT_S
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("timed out waiting for " + what)
        time.sleep(0.01)


def service(name, kind):
    rospy.wait_for_service(name, TIMEOUT_S)
    return rospy.ServiceProxy(name, kind)


def place(msg):
    p = msg.pose.position if hasattr(msg.pose, "position") else msg.pose.pose.position
    return np.array([p.x, p.y, p.z])


class UavSimulatorFaultsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.lock, cls.states, cls.truths = threading.Lock(), {}, {}
        cls.control, cls.now_s = None, 0.0
        rospy.Subscriber("/clock", Clock, cls.on_clock, queue_size=100)
        rospy.Subscriber("estimation_manager/uav_state", UavState, cls.on_state, queue_size=1000)
        rospy.Subscriber("uav_simulator/ground_truth", Odometry, cls.on_truth, queue_size=1000)
        rospy.Subscriber("control_manager/diagnostics", ControlManagerDiagnostics, cls.on_control, queue_size=100)
        takeoff = service("uav_manager/takeoff", Trigger)
        wait_for(lambda: cls.control is not None and takeoff().success, "take-off")
        wait_for(lambda: cls.control.flying_normally, "flying normally")

    @classmethod
    def on_clock(cls, msg):
        cls.now_s = msg.clock.to_sec()

    @classmethod
    def on_state(cls, msg):
        with cls.lock:
            cls.states[msg.header.stamp.to_nsec()] = (msg.estimator_iteration, place(msg))

    @classmethod
    def on_truth(cls, msg):
        with cls.lock:
            cls.truths[msg.header.stamp.to_nsec()] = place(msg)

    @classmethod
    def on_control(cls, msg):
        cls.control = msg

    def test_1_resets_are_counted_and_move_the_estimate_alone(self):
        wait_for(lambda: len(self.by_iteration()) >= 3, "two resets")
        offsets = [self.offset(stamp) for stamp in self.by_iteration().values()]
        for before, after in zip(offsets, offsets[1:]):
            self.assertAlmostEqual(np.linalg.norm(after - before), 2.0, delta=0.05)

    def by_iteration(self):
        """Returns {iteration: a stamp at which it and the truth are known}."""
        with self.lock:
            return {state[0]: stamp for stamp, state in sorted(self.states.items()) if stamp in self.truths}

    def offset(self, stamp):
        return self.states[stamp][1] - self.truths[stamp]

    def test_2_references_are_refused_while_braking(self):
        goto, hover = service("control_manager/goto", Vec4), service("control_manager/hover", Trigger)
        here = self.states[max(self.states)][1]
        self.assertTrue(goto([here[0] + 60.0, here[1], 2.0, 0.0]).success)
        wait_for(lambda: np.linalg.norm(self.states[max(self.states)][1] - here) > 6.0, "flight")
        self.assertTrue(hover().success)
        answer = goto([0.0, 0.0, 2.0, 0.0])
        self.assertFalse(answer.success)
        self.assertIn("callbacks are disabled", answer.message)
        wait_for(lambda: self.control.tracker_status.callbacks_enabled, "callbacks after braking")
        self.assertTrue(goto([0.0, 0.0, 2.0, 0.0]).success)

    def test_3_services_take_simulated_time(self):
        hover = service("control_manager/hover", Trigger)
        get_path = service("trajectory_generation/get_path", GetPathSrv)
        begin_s = self.now_s
        hover()
        self.assertGreater(self.now_s - begin_s, 0.35)
        path = Path(fly_now=True)
        for x in (0.0, 3.0):
            path.points.append(Reference())
            path.points[-1].position.x, path.points[-1].position.z = x, 2.0
        begin_s = self.now_s
        self.assertTrue(get_path(path).success)
        self.assertGreater(self.now_s - begin_s, 0.95)

    def test_4_messages_are_lost(self):
        with self.lock:
            stamps = sorted(self.truths)[-1000:]
            share = np.mean([stamp not in self.states for stamp in stamps])
        self.assertGreater(len(stamps), 300)
        self.assertGreater(share, 0.1)
        self.assertLess(share, 0.3)


if __name__ == "__main__":
    rospy.init_node("uav_simulator_faults_test")
    rostest.rosrun("voxnav", "uav_simulator_faults_test", UavSimulatorFaultsTest, sys.argv)
