#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The vehicle flies round what its safety area cuts off, refuses goals beyond its fences, and returns home."""

import sys
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import Point
from mrs_msgs.srv import ReferenceStampedSrv, ReferenceStampedSrvRequest
from sensor_msgs.msg import BatteryState
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker, MarkerArray

from voxnav.demo import mission
from voxnav.demo.record import FlightRecord
from voxnav.fences.world_config import load_world_config
from voxnav.nodes.flight_recorder import FlightRecorder
from voxnav.srv import AddZone, AddZoneRequest

WORLD, SEED = "grove", 1
LIMIT_S = 120.0  # limit of wall time for every wait
FRAME = "uav1/voxnav_map"


def is_inside(outline, point):
    """Returns whether a point is inside a polygon (n, 2), by the angle under which it sees the outline."""
    away = outline - point
    turns = np.diff(np.arctan2(away[:, 1], away[:, 0]), append=np.arctan2(away[0, 1], away[0, 0]))
    return abs(((turns + np.pi) % (2.0 * np.pi) - np.pi).sum()) > 3.0


class FencesTest(unittest.TestCase):
    def setUp(self):
        self.record = FlightRecord(WORLD, SEED)
        self.recorder = FlightRecorder(self.record)
        self.area = load_world_config(mission.repository_file("test/support/world_config.yaml")).area
        self.set_reference = rospy.ServiceProxy("planning_manager/reference", ReferenceStampedSrv)
        self.add_zone = rospy.ServiceProxy("planning_manager/add_zone", AddZone)
        self.clear_zones = rospy.ServiceProxy("planning_manager/clear_zones", Trigger)
        self.return_home = rospy.ServiceProxy("planning_manager/return_home", Trigger)
        self.battery = rospy.Publisher("hw_api/battery_state", BatteryState, queue_size=1)
        self.charge = 0.06
        self.timer = rospy.Timer(rospy.Duration(0.5), lambda _: self.battery.publish(percentage=self.charge))
        self.markers = []
        rospy.Subscriber("planning_manager/fence_markers", MarkerArray, lambda msg: self.markers.append(msg.markers))

    def wait(self, condition, what):
        self.recorder.wait_until(condition, LIMIT_S, what)

    def goal(self, position):
        request = ReferenceStampedSrvRequest()
        request.header.frame_id = FRAME
        p = request.reference.position
        p.x, p.y, p.z = position
        return self.set_reference(request)

    def zone(self, name, low, high):
        outline = [Point(low, -3.0, 0.0), Point(high, -3.0, 0.0), Point(high, 3.0, 0.0), Point(low, 3.0, 0.0)]
        return self.add_zone(AddZoneRequest(name=name, frame_id="world_origin", outline=outline, min_z=-5.0, max_z=9.0))

    def arrive(self):
        self.wait(lambda: not self.recorder.status.has_goal, "the goal")
        self.assertTrue(self.recorder.status.is_goal_reached, self.recorder.status.reason)

    def place(self):
        return self.places()[-1]

    def places(self):
        return self.record.truth_track.arrays()[1]

    def check_refusals(self):
        answer = self.goal((30.0, 20.0, 2.0))
        self.assertFalse(answer.success)
        self.assertEqual(answer.message, "goal is outside the safety area")
        self.wait(lambda: self.recorder.status.refusal == answer.message, "the refusal in the status")
        refused = self.zone("bow tie", 5.0, 5.0)
        self.assertFalse(refused.success)
        self.assertIn("bow tie: edges of the outline cross", refused.message)
        self.assertTrue(self.zone("pond", 27.0, 34.0).success)
        self.assertEqual(self.goal((30.0, 0.0, 2.0)).message, "goal is in the no-fly zone pond")
        self.wait(lambda: {("zone pond", Marker.LINE_LIST), ("zone pond walls", Marker.TRIANGLE_LIST)} <=
                  {(marker.ns, marker.type) for marker in self.markers[-1]}, "the markers of the zone")
        self.assertTrue(self.clear_zones().success)
        self.wait(lambda: "the battery holds 60 s, of which 60 s are reserve" in self.goal((30.0, 8.0, 2.0)).message,
                  "the refusal because of the battery")
        self.assertFalse(self.recorder.status.has_goal)
        self.charge = 1.0

    def check_the_area_of_the_control_manager(self):
        """A goal in an area that voxnav does not know of is dropped as soon as the control manager has refused it."""
        self.wait(lambda: self.goal((35.0, 11.0, 2.0)).success, "a goal, once the battery is known as charged")
        words = "the control manager refuses the goal: the point is outside of the safety area"
        self.wait(lambda: self.recorder.status.refusal == words, "the refusal of the control manager")
        self.wait(lambda: self.recorder.status.reason == "goal dropped: " + words, "the goal to be dropped")
        self.assertLess(np.linalg.norm(self.place()[:2]), 3.0)

    def test_flies_within_its_fences_and_returns_home(self):
        self.recorder.wait_for_nodes(LIMIT_S)
        self.recorder.take_off(LIMIT_S)
        self.check_refusals()
        self.check_the_area_of_the_control_manager()
        goal = mission.goal_of(mission.simulated_world(WORLD, SEED))
        self.wait(lambda: self.goal(goal).success, "the battery to be known as charged")
        self.recorder.send_goal(FRAME, goal)
        self.arrive()
        self.assertGreater(max(p[1] for p in self.places()), 3.0)
        status = self.recorder.status
        self.assertTrue(status.is_way_home_known)
        self.assertGreater(status.way_home_m, 31.0)
        self.assertGreater(status.way_home_s, status.way_home_m / 8.0)
        answer = self.return_home()
        self.assertTrue(answer.success, answer.message)
        self.wait(lambda: self.recorder.status.has_goal, "the planner to take the start as its goal")
        self.arrive()
        self.assertLess(np.linalg.norm(self.place()[:2]), 2.0)
        for place in self.places():
            self.assertTrue(is_inside(self.area.points, place[:2]), place)
        self.assertGreater(self.record.min_clearance_m, 0.5)


if __name__ == "__main__":
    rospy.init_node("fences_test")
    rostest.rosrun("voxnav", "fences_test", FencesTest, sys.argv)
