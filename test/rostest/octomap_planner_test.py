#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The services and diagnostics of mrs_octomap_planner, called as a user of MRS does."""

import math
import sys
import time
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import Point
from mrs_modules_msgs.msg import OctomapPlannerDiagnostics
from mrs_msgs.srv import (ReferenceStampedSrv, ReferenceStampedSrvRequest, String, ValidateReferenceArray,
                          ValidateReferenceArrayRequest, Vec1, Vec4)
from std_srvs.srv import Trigger

from planning_manager_test import O, SHIFT, UAV, W, FakeUav
from voxnav.nodes.planning_services import reference
from voxnav.srv import FindPath, FindPathRequest


def proxy(name, service_class):
    rospy.wait_for_service(UAV + name, 30.0)
    return rospy.ServiceProxy(UAV + name, service_class)


class OctomapPlannerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.uav, cls.diagnostics = FakeUav(), []
        rospy.Subscriber(UAV + "octomap_planner/diagnostics", OctomapPlannerDiagnostics, cls.diagnostics.append)
        cls.goto = proxy("octomap_planner/goto", Vec4)
        cls.stop = proxy("octomap_planner/stop", Trigger)
        cls.distance = proxy("octomap_planner/distance", Vec1)
        cls.altitude = proxy("octomap_planner/altitude", Vec1)

    def wait(self, condition, what, timeout_s=30.0):
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            if condition():
                return
            time.sleep(0.02)
        self.fail("waited in vain for " + what)

    def fly(self, goal_O, heading_rad=0.0):
        """Calls goto until the map correction is known."""
        self.wait(lambda: self.goto(list(goal_O) + [heading_rad]).success, "a goal that is taken")

    def wait_for_arrival(self, goal_O):
        self.wait(lambda: np.linalg.norm(self.uav.position - goal_O) < 1.0, "the vehicle at %s" % (goal_O,), 40.0)
        self.wait(lambda: self.diagnostics[-1].idle, "idle")

    def test_1_goto_flies_in_the_control_frame_and_looks_ahead(self):
        del self.uav.paths[:]
        self.fly((10.0, 6.0, 3.0), heading_rad=1.5)
        self.wait(lambda: self.diagnostics and not self.diagnostics[-1].idle, "diagnostics that say it flies")
        said = self.diagnostics[-1]
        self.assertEqual(said.header.frame_id, W)
        np.testing.assert_allclose([said.desired_reference.x, said.desired_reference.y, said.desired_reference.z],
                                   np.array([10.0, 6.0, 3.0]) + SHIFT, atol=1e-6)
        self.wait_for_arrival((10.0, 6.0, 3.0))
        self.assertTrue(all(path.use_heading and path.relax_heading for path in self.uav.paths))
        headings = [p.heading for p in self.uav.paths[0].points]
        for heading in headings[:-1]:
            self.assertAlmostEqual(heading, math.atan2(6.0, 10.0) + 0.5, delta=0.2)
        self.assertGreaterEqual(len(headings), 3)
        self.assertAlmostEqual(headings[-1], 1.5, delta=1e-6)  # that of the goal, where a path ends at it

    def test_2_the_diagnostics_come_ten_times_a_second_and_name_the_end_of_the_plan(self):
        self.fly((-4.0, 0.0, 3.0))
        self.wait(lambda: abs(self.diagnostics[-1].best_goal.x - (-4.0 + SHIFT[0])) < 0.5, "the end of the plan")
        begin = len(self.diagnostics)
        self.wait(lambda: len(self.diagnostics) >= begin + 21, "diagnostics")
        stamps = [m.header.stamp.to_sec() for m in self.diagnostics[begin:begin + 21]]
        self.assertAlmostEqual((stamps[-1] - stamps[0]) / 20.0, 0.1, delta=0.03)
        self.wait_for_arrival((-4.0, 0.0, 3.0))

    def test_3_stop_and_reference(self):
        service = proxy("octomap_planner/reference", ReferenceStampedSrv)
        request = ReferenceStampedSrvRequest(reference=reference((16.0, 2.0, 3.0), 0.0))
        request.header.frame_id = W
        self.assertTrue(service(request).success)
        self.wait(lambda: not self.diagnostics[-1].idle, "a flight")
        hovers = self.uav.num_hovers
        self.assertTrue(self.stop().success)
        self.wait(lambda: self.uav.num_hovers > hovers and self.diagnostics[-1].idle, "the stop")
        request.header.frame_id = "nowhere"
        refused = service(request)
        self.assertFalse(refused.success)
        self.assertIn("no transform from frame 'nowhere' to %s: " % O, refused.message)
        self.assertIn("does not exist", refused.message)  # as tf says

    def test_4_the_safety_distance_has_bounds(self):
        for value in (0.5, 5.1, float("nan"), float("inf"), -1.0):
            refused = self.distance(value)
            self.assertFalse(refused.success, value)
            self.assertIn("outside of the allowed range [0.60, 5.00] m", refused.message)
        low = self.distance(0.7)
        self.assertTrue(low.success)
        self.assertIn("what is flown keeps 0.90 m", low.message)
        self.assertTrue(self.distance(1.2).success)
        self.fly((0.0, 0.0, 3.0))
        self.wait_for_arrival((0.0, 0.0, 3.0))

    def test_5_the_highest_altitude_holds_for_later_goals(self):
        self.assertTrue(self.altitude(4.0).success)
        refused = self.goto([4.0, 0.0, 5.0, 0.0])
        self.assertFalse(refused.success)
        self.assertIn("above the highest altitude of 4.0 m", refused.message)
        for value in (float("nan"), -10.0):
            self.assertFalse(self.altitude(value).success)
        self.assertTrue(self.altitude(50.0).success)
        self.fly((4.0, 0.0, 5.0))
        self.wait_for_arrival((4.0, 0.0, 5.0))

    def test_6_every_planner_of_mrs_is_stood_in_for(self):
        service = proxy("octomap_planner/set_planner", String)
        for name in ("mrs", "subt"):
            self.assertTrue(service(name).success)
        self.assertFalse(service("rrt").success)

    def test_7_paths_are_found_without_flying(self):
        service = proxy("minimal_octomap_planner/get_path", FindPath)
        position = self.uav.position.copy()
        request = FindPathRequest(start=Point(0.0, 0.0, 3.0), end=Point(12.0, 5.0, 4.0))
        found = service(request)
        self.assertTrue(found.success, found.message)
        self.assertEqual(found.header.frame_id, O)
        ends = [[p.x, p.y, p.z] for p in (found.path[0], found.path[-1])]
        np.testing.assert_allclose(ends, [[0.0, 0.0, 3.0], [12.0, 5.0, 4.0]], atol=0.5)
        request.header.frame_id = W
        request.start.x, request.end.x = 0.0 + SHIFT[0], 12.0 + SHIFT[0]
        in_W = service(request)
        np.testing.assert_allclose([in_W.path[0].x, in_W.path[-1].x], [SHIFT[0], 12.0 + SHIFT[0]], atol=0.5)
        request.end.x = float("nan")
        self.assertIn("not finite", service(request).message)
        request.header.frame_id = "nowhere"
        self.assertIn("no transform", service(request).message)
        np.testing.assert_allclose(self.uav.position, position, atol=0.05)

    def test_8_virtual_obstacles_are_flown_round_until_they_are_removed(self):
        add = proxy("octomap_planner/add_virtual_obstacle", ValidateReferenceArray)
        remove = proxy("octomap_planner/remove_virtual_obstacles", Trigger)
        self.fly((0.0, 0.0, 3.0))
        self.wait_for_arrival((0.0, 0.0, 3.0))
        corners = [(6.0, -3.0, 0.0), (8.0, -3.0, 8.0), (6.0, 3.0, 0.0)]
        request = ValidateReferenceArrayRequest()
        request.array.header.frame_id = O
        request.array.array = [reference(corner, 0.0) for corner in corners]
        added = add(request)
        self.assertEqual(list(added.success), [True], added.message)
        refused = self.goto([7.0, 0.0, 3.0, 0.0])
        self.assertFalse(refused.success)
        path = proxy("minimal_octomap_planner/get_path", FindPath)
        way = FindPathRequest(start=Point(0.0, 0.0, 3.0), end=Point(14.0, 0.0, 3.0))
        round_m = np.array([(p.x, p.y, p.z) for p in path(way).path])
        self.assertGreater(np.abs(round_m[:, 1]).max(), 3.0)
        self.assertIn("1 virtual obstacles", remove().message)
        straight = np.array([(p.x, p.y, p.z) for p in path(way).path])
        self.assertLess(np.abs(straight[:, 1]).max(), 1.0)

    def test_9_virtual_obstacles_that_are_none_are_refused(self):
        add = proxy("octomap_planner/add_virtual_obstacle", ValidateReferenceArray)
        places = [(6.0, -3.0, 0.0), (8.0, -3.0, 8.0), (6.0, 3.0, 0.0)]
        for frame, corners, reason in ((O, places[:2], "exactly 3 points"), ("nowhere", places, "does not exist"),
                                       (O, [places[0]] * 3, ""), (O, [(1e5, 0, 0), (0, 1e5, 9), (0, 0, 0)], "")):
            request = ValidateReferenceArrayRequest()
            request.array.header.frame_id = frame
            request.array.array = [reference(corner, 0.0) for corner in corners]
            refused = add(request)
            self.assertEqual(list(refused.success), [False], corners)
            self.assertTrue(refused.message)
            self.assertIn(reason, refused.message)
        self.assertIn("0 virtual obstacles", proxy("octomap_planner/remove_virtual_obstacles", Trigger)().message)


if __name__ == "__main__":
    rospy.init_node("octomap_planner_test")
    rostest.rosrun("voxnav", "octomap_planner", OctomapPlannerTest, sys.argv)
