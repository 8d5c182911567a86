#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Whoever else takes the simulated vehicle keeps it, and the flight follows the estimator to another origin."""

import math
import sys
import time
import unittest

import numpy as np
import rospy
import rostest
from mrs_msgs.msg import Path, Reference, TrackerCommand
from mrs_msgs.srv import (PathSrv, ReferenceStampedSrv, ReferenceStampedSrvRequest, String, Vec4)
from nav_msgs.msg import Odometry
from std_srvs.srv import SetBool, Trigger

from voxnav.demo.record import FlightRecord
from voxnav.nodes.flight_recorder import FlightRecorder, MissionError
from voxnav.planning_manager.input_ids import is_own

LIMIT_S = 60.0  # limit of wall time for every wait
W = "uav1/voxnav_map"
HEIGHT_M = 2.0


class TakeoverTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.recorder = FlightRecorder(FlightRecord("grove", 1))
        cls.truth = cls.command = cls.odometry_frame = None
        rospy.Subscriber("uav_simulator/ground_truth", Odometry, cls.on_truth, queue_size=1)
        rospy.Subscriber("estimation_manager/odom_main", Odometry, cls.on_odometry, queue_size=1)
        rospy.Subscriber("control_manager/tracker_cmd", TrackerCommand, cls.on_command, queue_size=1)
        cls.recorder.wait_for_nodes(LIMIT_S)
        cls.recorder.take_off(LIMIT_S)

    @classmethod
    def on_truth(cls, msg):
        p = msg.pose.pose.position
        cls.truth = np.array([p.x, p.y, p.z])

    @classmethod
    def on_odometry(cls, msg):
        cls.odometry_frame = msg.header.frame_id

    @classmethod
    def on_command(cls, msg):
        cls.command = msg

    @property
    def status(self):
        return self.recorder.status

    def wait(self, condition, what):
        try:
            self.recorder.wait_until(condition, LIMIT_S, what)
        except MissionError as error:
            self.fail("%s; now: %s" % (error, self.status and self.status.reason))

    def call(self, name, kind, *arguments):
        rospy.wait_for_service(name, LIMIT_S)
        answer = rospy.ServiceProxy(name, kind)(*arguments)
        self.assertTrue(answer.success, "%s: %s" % (name, answer.message))

    def fly(self, frame=W, goal=(15.0, -4.0, HEIGHT_M)):
        """Sends a goal and waits until the vehicle moves to it."""
        self.recorder.send_goal(frame, goal)
        self.wait(lambda: self.recorder.speed_mps > 0.8 and self.status.reason.startswith("moving"), "a flight")

    def assert_dropped(self, words):
        """Asserts that the goal is dropped with the reason, and that voxnav commands nothing until a new goal."""
        self.wait(lambda: not self.status.has_goal, "the goal to be dropped")
        self.assertIn(words, self.status.reason)
        self.assertTrue(self.status.reason.startswith("goal dropped: "), self.status.reason)
        before = (self.status.num_trajectories, self.status.num_hovers)
        end = self.status.header.stamp + rospy.Duration(2.0)
        self.wait(lambda: self.status.header.stamp > end, "two seconds")
        self.assertEqual((self.status.num_trajectories, self.status.num_hovers), before)
        self.assertFalse(self.status.has_goal)

    def test_1_a_hover_of_another_node(self):
        self.fly()
        self.assertTrue(is_own(self.command.full_state_prediction.input_id))
        self.call("control_manager/hover", Trigger)
        self.assert_dropped("somebody else let the vehicle hover")
        self.assertLess(self.recorder.speed_mps, 0.2)

    def test_2_references_of_another_node(self):
        self.fly()
        self.call("control_manager/goto_relative", Vec4, [0.0, 0.0, 1.0, 0.0])
        self.assert_dropped("somebody else commands the vehicle")
        self.fly()
        path = Path(fly_now=True, use_heading=False, relax_heading=True)
        path.header.frame_id = "uav1/ground_truth_origin"
        for back_m in (0.0, 2.0):
            path.points.append(Reference())
            p = path.points[-1].position
            p.x, p.y, p.z = self.truth - (back_m, 0.0, 0.0)
        self.call("trajectory_generation/path", PathSrv, path)
        self.assert_dropped("somebody else flies a trajectory, with the input_id 0")
        self.wait(lambda: self.recorder.speed_mps < 0.1, "the end of that trajectory")

    def test_3_a_pilot_and_callbacks_that_are_taken_away(self):
        self.fly()
        self.call("uav_simulator/remote_control", SetBool, True)
        self.assert_dropped("a pilot flies the vehicle by remote control")
        request = ReferenceStampedSrvRequest()
        request.header.frame_id, request.reference.position.z = W, HEIGHT_M
        answer = rospy.ServiceProxy("planning_manager/reference", ReferenceStampedSrv)(request)
        self.assertFalse(answer.success)
        self.assertEqual(answer.message, "a pilot flies the vehicle by remote control")
        self.call("uav_simulator/remote_control", SetBool, False)
        self.wait(lambda: not self.recorder._control.joystick_active, "the vehicle to be given back")
        self.fly()
        self.call("control_manager/enable_callbacks", SetBool, False)
        self.assert_dropped("callbacks are disabled")
        self.call("control_manager/enable_callbacks", SetBool, True)
        self.wait(lambda: self.recorder._control.flying_normally, "the callbacks")

    def test_3b_an_emergency_hover(self):
        self.fly()
        self.call("control_manager/ehover", Trigger)
        self.assert_dropped("it is an emergency (LandoffTracker with EmergencyController)")
        self.assertLess(self.recorder.speed_mps, 0.2)
        self.call("control_manager/switch_tracker", String, "MpcTracker")
        self.call("control_manager/switch_controller", String, "Se3Controller")
        self.call("control_manager/enable_callbacks", SetBool, True)
        self.wait(lambda: self.recorder._control.flying_normally, "the vehicle to be given back")

    def test_4_a_safety_area_that_cuts_the_trajectory(self):
        self.recorder.send_goal(W, (24.0, 0.0, HEIGHT_M))
        self.wait(lambda: not self.status.has_goal, "the goal to be dropped")
        self.assertIn("safety area", self.status.reason)
        self.wait(lambda: self.recorder.speed_mps < 0.1, "rest")
        self.assertLess(self.truth[0], 18.5)
        self.call("control_manager/goto", Vec4, [16.0, -4.0, HEIGHT_M, 0.0])  # no flight may begin beyond the edge
        self.wait(lambda: np.linalg.norm(self.truth[:2] - (16.0, -4.0)) < 0.5 and self.recorder.speed_mps < 0.1,
                  "the return into the area")

    def test_5_a_switch_of_the_estimator_in_flight(self):
        """The origins are 3.7 m and 0.3 rad apart: with poses of one on a map of the other the goal would be missed."""
        self.fly(goal=(2.0, 1.0, HEIGHT_M))
        num_hovers = self.status.num_hovers
        self.call("estimation_manager/change_estimator", String, "gps_baro")
        self.wait(lambda: self.odometry_frame == "uav1/gps_baro_origin", "the other origin")
        self.wait(lambda: self.status.is_goal_reached, "the goal")
        self.assertLess(np.linalg.norm(self.truth - (2.0, 1.0, HEIGHT_M)), 1.2)
        self.assertGreater(self.status.num_hovers, num_hovers)
        goal = (-3.0, 2.0, 1.0, 0.0)  # in the control frame, whose origin is at (3, -2, 1) with heading 0.3
        self.call("planning_manager/goto", Vec4, goal)
        expected = np.array([3.0 - 3.0 * math.cos(0.3) - 2.0 * math.sin(0.3),
                             -2.0 - 3.0 * math.sin(0.3) + 2.0 * math.cos(0.3), 2.0])
        self.wait(lambda: self.status.has_goal and self.distance_of_goal(expected) < 0.3, "that goal")
        self.call("planning_manager/stop", Trigger)

    def distance_of_goal(self, place):
        goal = self.status.goal
        return np.linalg.norm(place - (goal.x, goal.y, goal.z))

    def test_5b_an_emergency_landing_and_a_failsafe(self):
        for name, told in (("eland", "the vehicle lands (LandoffTracker with EmergencyController)"),
                           ("failsafe", "it is an emergency (MpcTracker with FailsafeController)")):
            self.fly(goal=(10.0, 0.0, HEIGHT_M))
            self.call("control_manager/" + name, Trigger)
            self.assert_dropped(told)
            self.wait(lambda: not self.recorder._control.output_enabled, "the end of it")
            self.recorder.take_off(LIMIT_S)

    def test_6_a_landing_and_the_next_take_off(self):
        self.fly(goal=(10.0, 0.0, HEIGHT_M))
        self.call("uav_manager/land", Trigger)
        self.assert_dropped("the vehicle lands")
        self.wait(lambda: not self.recorder._control.output_enabled, "the landing")
        self.recorder.take_off(LIMIT_S)
        here = self.truth
        end = time.monotonic() + 1.5
        self.wait(lambda: time.monotonic() > end, "a while in the air")
        self.assertLess(np.linalg.norm((self.truth - here)[:2]), 0.5)
        self.assertFalse(self.status.has_goal)


if __name__ == "__main__":
    rospy.init_node("takeover_test")
    rostest.rosrun("voxnav", "takeover_test", TakeoverTest, sys.argv)
