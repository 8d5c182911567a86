#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The vehicle flies up a hillside to a goal 6 m higher, and its height above the ground stays within its limits."""

import sys
import unittest

import numpy as np
import rospy
import rostest

from voxnav.demo import mission
from voxnav.demo.record import FlightRecord
from voxnav.nodes.flight_recorder import FlightRecorder

WORLD, SEED = "hill", 1
LIMIT_S = 240.0  # limit of wall time for every wait
FRAME = "uav1/voxnav_map"
MIN_HEIGHT_M, MAX_HEIGHT_M = 1.2, 4.0  # as in test/support/hill.yaml
# Limits count whole voxels of 0.4 m, ground that is not seen yet limits nothing, and trajectories leave their paths.
BELOW_M, ABOVE_M = 0.4, 1.2


class HillTest(unittest.TestCase):
    def test_flies_up_the_hill_at_its_height_above_the_terrain(self):
        world = mission.simulated_world(WORLD, SEED)
        goal = mission.goal_of(world)
        self.assertGreater(goal[2] - 2.0, 5.9, "the ground of the goal is 6 m higher than that of the start")
        record = FlightRecord(WORLD, SEED)
        recorder = FlightRecorder(record)
        recorder.wait_for_nodes(LIMIT_S)
        recorder.take_off(LIMIT_S)
        begin = len(record.truth_track.arrays()[1])
        recorder.send_goal(FRAME, goal)
        recorder.wait_until(lambda: recorder.status.has_goal, LIMIT_S, "the planner to take the goal")
        recorder.wait_until(lambda: not recorder.status.has_goal, LIMIT_S, "the goal")
        self.assertTrue(recorder.status.is_goal_reached, recorder.status.reason)
        places = record.truth_track.arrays()[1][begin:]
        heights = np.array([p[2] - world.ground_height(p[0], p[1]) for p in places])
        rospy.loginfo("heights above the ground: %.2f m to %.2f m, clearance %.2f m", heights.min(), heights.max(),
                      record.min_clearance_m)
        self.assertGreater(np.ptp(places[:, 2]), 5.0)
        self.assertGreater(heights.min(), MIN_HEIGHT_M - BELOW_M)
        self.assertLess(heights.max(), MAX_HEIGHT_M + ABOVE_M)
        self.assertGreater(record.min_clearance_m, 0.8)
        self.assertFalse(record.has_collided)


if __name__ == "__main__":
    rospy.init_node("hill_test")
    rostest.rosrun("voxnav", "hill_test", HillTest, sys.argv)
