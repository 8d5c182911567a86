#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""When a node is killed in flight, the vehicle comes to rest with a reason, and flies on when the node is back."""

import subprocess
import sys
import time
import unittest

import rosgraph
import rospy
import rosservice
import rostest

from voxnav.demo import mission
from voxnav.demo.record import FlightRecord
from voxnav.nodes.flight_recorder import FlightRecorder

WORLD, SEED = "grove", 1
LIMIT_S = 90.0  # limit of wall time for every wait
FRAME = "uav1/voxnav_map"
MRS_TOPICS = {
    "estimation_manager/uav_state": "mrs_msgs/UavState", "estimation_manager/odom_main": "nav_msgs/Odometry",
    "estimation_manager/diagnostics": "mrs_msgs/EstimationDiagnostics",
    "control_manager/diagnostics": "mrs_msgs/ControlManagerDiagnostics",
    "control_manager/tracker_cmd": "mrs_msgs/TrackerCommand",
    "control_manager/current_constraints": "mrs_msgs/DynamicsConstraints",
    "control_manager/reference": "mrs_msgs/ReferenceStamped",
    "control_manager/trajectory_reference": "mrs_msgs/TrajectoryReference",
    "constraint_manager/diagnostics": "mrs_msgs/ConstraintManagerDiagnostics",
    "uav_manager/diagnostics": "mrs_msgs/UavManagerDiagnostics", "hw_api/gnss": "sensor_msgs/NavSatFix",
    "hw_api/rtk": "mrs_msgs/RtkGps", "hw_api/imu": "sensor_msgs/Imu", "hw_api/distance_sensor": "sensor_msgs/Range",
    "os_cloud_nodelet/points": "sensor_msgs/PointCloud2", "mrs_uav_status/display_string": "std_msgs/String",
    "local_mapper/octomap": "octomap_msgs/Octomap", "planning_manager/reference": "mrs_msgs/ReferenceStamped",
}
MRS_SERVICES = {
    "control_manager/trajectory_reference": "mrs_msgs/TrajectoryReferenceSrv",
    "control_manager/reference": "mrs_msgs/ReferenceStampedSrv", "control_manager/goto": "mrs_msgs/Vec4",
    "control_manager/hover": "std_srvs/Trigger", "control_manager/stop_trajectory_tracking": "std_srvs/Trigger",
    "constraint_manager/set_constraints": "mrs_msgs/String", "uav_manager/takeoff": "std_srvs/Trigger",
    "uav_manager/land": "std_srvs/Trigger", "trajectory_generation/get_path": "mrs_msgs/GetPathSrv",
    "trajectory_generation/path": "mrs_msgs/PathSrv", "planning_manager/reference": "mrs_msgs/ReferenceStampedSrv",
    "planning_manager/goto": "mrs_msgs/Vec4", "planning_manager/stop": "std_srvs/Trigger",
}


class FlightTest(unittest.TestCase):
    def setUp(self):
        self.record = FlightRecord(WORLD, SEED)
        self.recorder = FlightRecorder(self.record)

    def wait(self, condition, what):
        self.recorder.wait_until(condition, LIMIT_S, what)

    def kill(self, node):
        subprocess.check_call(["rosnode", "kill", rospy.resolve_name(node)], stdout=subprocess.DEVNULL)

    def kill_in_flight(self, victim):
        self.wait(lambda: self.recorder.speed_mps > 0.5, "flight before killing " + victim)
        num_reasons, began = len(self.recorder.reasons), time.monotonic()
        self.kill(victim)
        # Hovering or braking is enough: if the node is back soon, the vehicle does not come to rest.
        self.wait(lambda: any(reason.startswith(("hover", "brake")) for reason in self.recorder.reasons[num_reasons:]),
                  "hover after killing " + victim)
        self.wait(lambda: self.recorder.reasons[-1].startswith("moving") and self.recorder.speed_mps > 0.5,
                  "flight after killing " + victim)
        print("%s: flies on %.1f s after it was killed; %s" % (
            victim, time.monotonic() - began, self.recorder.reasons[num_reasons:]))

    def kill_planner(self):
        """Kills the planner, which then cannot brake; but its trajectory ends at rest, and the goal is kept."""
        self.wait(lambda: self.recorder.speed_mps > 0.5, "flight before killing the planner")
        before = self.recorder.status.header.stamp
        self.kill("planning_manager")
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
        self.kill("lidar_simulator")  # simulated time waits for this node, so the vehicle need not come to rest
        self.arrive()
        self.recorder.send_goal(FRAME, (0.0, 0.0, 2.0))
        for victim in ("submap_optimizer", "voxnav_nodelet_manager"):
            self.kill_in_flight(victim)
        self.kill_planner()
        self.arrive()
        self.assertGreater(self.record.min_clearance_m, 0.5)

    def test_interfaces_are_those_of_mrs(self):
        """Topics and services have the names and types of the MRS system; md5 sums have a test of their own."""
        self.recorder.wait_for_nodes(LIMIT_S)
        topics = dict(rosgraph.Master("/flight_test").getTopicTypes())
        for topic, kind in MRS_TOPICS.items():
            self.assertEqual(topics.get("/uav1/" + topic), kind, topic)
        for service, kind in MRS_SERVICES.items():
            self.assertEqual(rosservice.get_service_type("/uav1/" + service), kind, service)


if __name__ == "__main__":
    rospy.init_node("flight_test")
    rostest.rosrun("voxnav", "flight_test", FlightTest, sys.argv)
