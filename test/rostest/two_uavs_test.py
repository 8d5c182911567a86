#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Two simulated UAVs hear each other, cross a grove towards each other's start, and do not map each other's body."""

import sys
import unittest

import rospy
import rostest

from voxnav.demo.mission import goal_of, simulated_world
from voxnav.msg import NodeDiagnostics, OtherUavs
from voxnav.nodes.two_uavs_mission import FlightOfTwo

GOALS = (tuple(goal_of(simulated_world("grove", seed=1))), (0.0, 0.0, 2.0))
LIMIT_S = 90.0
NAMES = ("uav1", "uav2")


class TwoUavsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.others, cls.counters = {}, {}
        for name in NAMES:
            rospy.Subscriber("/%s/planning_manager/others" % name, OtherUavs, cls.on_others, name, queue_size=5)
            rospy.Subscriber("/%s/planning_manager/diagnostics" % name, NodeDiagnostics, cls.on_diagnostics, name)
        cls.flight = FlightOfTwo(NAMES)
        cls.flight.take_off()
        cls.flight.fly(GOALS, LIMIT_S)
        cls.result = cls.flight.result("")

    @classmethod
    def on_others(cls, msg, name):
        if msg.others:
            cls.others[name] = msg

    @classmethod
    def on_diagnostics(cls, msg, name):
        cls.counters[name] = dict(zip(msg.counter_names, msg.counter_values))

    def test_both_arrive_and_keep_clear(self):
        for name in NAMES:
            self.assertTrue(self.result["uavs"][name]["reached"], self.result["uavs"][name])
        self.assertFalse(self.result["has_collided"])
        self.assertGreater(self.result["least_distance_m"], 1.0)

    def test_each_knows_where_the_other_is_and_one_gives_way(self):
        self.assertEqual({name: [each.name for each in msg.others] for name, msg in self.others.items()},
                         {"uav1": ["uav2"], "uav2": ["uav1"]})
        self.assertTrue(self.others["uav1"].others[0].gives_way)
        self.assertFalse(self.others["uav2"].others[0].gives_way)
        for name in NAMES:
            self.assertEqual(self.counters[name]["num_others_refused"], 0.0)
            self.assertEqual(self.counters[name]["num_others_forgotten"], 0.0)


if __name__ == "__main__":
    rospy.init_node("two_uavs_test")
    rostest.rosrun("voxnav", "two_uavs_test", TwoUavsTest, sys.argv)
