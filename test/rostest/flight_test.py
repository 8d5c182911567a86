#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A flight over ROS in which nodes are killed: the vehicle comes to rest, says why, and goes on when they are back."""

import subprocess
import sys
import time
import unittest

import rospy
import rostest

from voxnav.demo import mission
from voxnav.demo.record import FlightRecord
from voxnav.nodes.flight_recorder import FlightRecorder

WORLD, SEED = "grove", 1
LIMIT_S = 90.0  # of wall time, for anything that is waited for
FRAME = "uav1/voxnav_map"


class FlightTest(unittest.TestCase):
    def setUp(self):
        self.record = FlightRecord(WORLD, SEED)
        self.recorder = FlightRecorder(self.record)

    def wait(self, condition, what):
        self.recorder.wait_until(condition, LIMIT_S, what)

    def kill_in_flight(self, victim):
        self.wait(lambda: self.recorder.speed_mps > 0.5, "flight before killing " + victim)
        num_reasons, began = len(self.recorder.reasons), time.monotonic()
        subprocess.check_call(["rosnode", "kill", rospy.resolve_name(victim)], stdout=subprocess.DEVNULL)
        self.wait(lambda: self.recorder.speed_mps < 0.1, "rest after killing " + victim)
        self.wait(lambda: self.recorder.speed_mps > 0.5, "flight after killing " + victim)
        reasons = self.recorder.reasons[num_reasons:]
        print("%s: flies on %.1f s after it was killed; %s" % (victim, time.monotonic() - began, reasons))
        self.assertTrue(any(reason.startswith(("hover", "brake")) for reason in reasons), reasons)

    def kill_planner(self):
        """It cannot brake any more, but every trajectory ends at rest in known free space, and the goal is kept."""
        self.wait(lambda: self.recorder.speed_mps > 0.5, "flight before killing the planner")
        before = self.recorder.status.header.stamp
        subprocess.check_call(["rosnode", "kill", rospy.resolve_name("planning_manager")], stdout=subprocess.DEVNULL)
        self.wait(lambda: self.recorder.status.header.stamp > before + rospy.Duration(1.0) and
                  self.recorder.status.num_plans <= 2, "the planner to come back")

    def arrive(self):
        self.wait(lambda: not self.recorder.status.has_goal, "the goal")
        self.assertTrue(self.recorder.status.is_goal_reached, self.recorder.status.reason)

    def test_flight_survives_the_loss_of_every_node(self):
        self.recorder.wait_for_nodes(LIMIT_S)
        self.recorder.take_off(LIMIT_S)
        self.recorder.send_goal(FRAME, mission.goal_of(mission.simulated_world(WORLD, SEED)))
        for victim in ("cloud_filter", "local_mapper", "submap_integrator"):
            self.kill_in_flight(victim)
        self.arrive()
        self.recorder.send_goal(FRAME, (0.0, 0.0, 2.0))
        for victim in ("submap_optimizer", "voxnav_nodelet_manager"):
            self.kill_in_flight(victim)
        self.kill_planner()
        self.arrive()
        self.assertGreater(self.record.min_clearance_m, 0.5)


if __name__ == "__main__":
    rospy.init_node("flight_test")
    rostest.rosrun("voxnav", "flight_test", FlightTest, sys.argv)
