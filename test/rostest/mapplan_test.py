#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A flight with mapplan.launch, by the names of the MRS packages alone, and the bumper that heeds voxnav's sectors."""

import os
import signal
import sys
import unittest
from xmlrpc.client import ServerProxy

import numpy as np
import rospy
import rostest
from mrs_modules_msgs.msg import OctomapPlannerDiagnostics
from mrs_msgs.msg import ObstacleSectors
from mrs_msgs.srv import Vec4
from nav_msgs.msg import Odometry
from octomap_msgs.msg import Octomap

from voxnav.demo.record import FlightRecord
from voxnav.nodes.flight_recorder import FlightRecorder, MissionError

LIMIT_S = 60.0  # limit of wall time for every wait
OPEN, BESIDE_TRUNK = (2.1, -7.7, 3.0), (-4.3, -5.6, 3.0)
TRUNK = (-5.7, -5.6)
REPELLED = "the bumper of the control manager repels the vehicle"


class MapplanTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.recorder = FlightRecorder(FlightRecord("grove", 1))
        cls.heard = {}
        for topic, kind in (("octomap_planner/diagnostics", OctomapPlannerDiagnostics),
                            ("octomap_server/octomap_local_full", Octomap),
                            ("octomap_server/octomap_global_full", Octomap),
                            ("bumper/obstacle_sectors", ObstacleSectors), ("uav_simulator/ground_truth", Odometry)):
            cls.heard[topic] = []
            rospy.Subscriber(topic, kind, cls.heard[topic].append, queue_size=50)
        cls.recorder.wait_for_nodes(LIMIT_S)
        cls.recorder.take_off(LIMIT_S)

    @property
    def status(self):
        return self.recorder.status

    @property
    def control(self):
        return self.recorder._control

    @property
    def place(self):
        p = self.heard["uav_simulator/ground_truth"][-1].pose.pose.position
        return np.array([p.x, p.y, p.z])

    def wait(self, condition, what):
        try:
            self.recorder.wait_until(condition, LIMIT_S, what)
        except MissionError as error:
            self.fail("%s; now: %s" % (error, self.status and self.status.reason))

    def call(self, name, goal):
        rospy.wait_for_service(name, LIMIT_S)
        return rospy.ServiceProxy(name, Vec4)(list(goal) + [0.0])

    def fly(self, goal):
        self.wait(lambda: self.call("octomap_planner/goto", goal).success, "a goal that is taken")

    def assert_sectors_never_ceased(self, since):
        """In simulated time, twice as fast as real time; MRS takes sectors older than one second for lost."""
        stamps = [m.header.stamp.to_sec() for m in self.heard["bumper/obstacle_sectors"] if m.header.stamp >= since]
        self.assertGreater(len(stamps), 5)
        self.assertLess(max(np.diff(stamps)), 0.9)

    def test_1_a_goal_is_flown_to_and_their_topics_tell_it(self):
        diagnostics = self.heard["octomap_planner/diagnostics"]
        self.fly(OPEN)
        self.wait(lambda: diagnostics and not diagnostics[-1].idle, "diagnostics of a flight")
        said = diagnostics[-1].desired_reference
        self.assertLess(np.linalg.norm(np.array([said.x, said.y, said.z]) - OPEN), 0.5)
        self.wait(lambda: self.status.is_goal_reached and diagnostics[-1].idle, "the goal")
        self.assertLess(np.linalg.norm(self.place - OPEN), 1.2)
        for name in ("local", "global"):
            maps = self.heard["octomap_server/octomap_%s_full" % name]
            self.wait(lambda: maps and len(maps[-1].data) > 100, "the %s map" % name)
            self.assertEqual((maps[-1].id, maps[-1].binary), ("OcTree", False))
            self.assertAlmostEqual(maps[-1].resolution, 0.4)

    def test_2_the_bumper_repels_and_the_goal_is_dropped(self):
        since = rospy.Time.now()
        self.fly(BESIDE_TRUNK)
        self.wait(lambda: self.control.bumper_active, "the bumper")
        self.assertFalse(self.control.flying_normally)
        self.wait(lambda: not self.status.has_goal, "the goal to be dropped")
        self.assertEqual(self.status.reason, "goal dropped: " + REPELLED)
        self.wait(lambda: not self.control.bumper_active and self.control.flying_normally, "its end")
        self.assert_sectors_never_ceased(since)
        self.assertGreater(np.linalg.norm(self.place[:2] - TRUNK), 1.5)  # the goal is nearer

    def kill_bumper_while_it_repels(self):
        """Flies towards the trunk, and kills the node, whose process roslaunch starts again after a second."""
        node = ServerProxy(rospy.get_master().lookupNode("/uav1/bumper")[2])
        pid = node.getPid("/mapplan_test")[2]
        self.call("control_manager/goto", BESIDE_TRUNK)
        self.wait(lambda: self.control.bumper_active, "the bumper")
        os.kill(pid, signal.SIGKILL)

    def test_3_sectors_that_cease_freeze_the_vehicle_and_a_goal_waits_until_they_come_back(self):
        """As in MRS: a bumper that hears nothing neither pushes nor lets go."""
        self.kill_bumper_while_it_repels()
        self.fly(OPEN)
        self.wait(lambda: self.status.reason == "waiting: " + REPELLED, "the reason")
        self.assertTrue(self.status.has_goal)
        self.wait(lambda: self.status.is_goal_reached, "the goal")
        self.assertLess(np.linalg.norm(self.place - OPEN), 1.2)


if __name__ == "__main__":
    rospy.init_node("mapplan_test")
    rostest.rosrun("voxnav", "mapplan_test", MapplanTest, sys.argv)
