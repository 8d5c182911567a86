#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The UAV simulator node has the names and types of MRS, flies, refuses bad commands, and keeps time in lock-step."""

import math
import sys
import threading
import time
import unittest

import rospy
import rostest
from geometry_msgs.msg import Point
from mrs_msgs.msg import ControlManagerDiagnostics, DynamicsConstraints, Path, Reference, TrackerCommand
from mrs_msgs.msg import ReferenceStamped, TrajectoryReference, UavState
from mrs_msgs.srv import (GetPathSrv, ReferenceStampedSrv, String, TrajectoryReferenceSrv, TransformReferenceSrv,
                          ValidateReference, ValidateReferenceArray, ValidateReferenceArrayRequest, Vec4)
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage

from voxnav.msg import Progress

TIMEOUT_S = 60.0


class Latest:
    def __init__(self, topic, kind):
        self.message, self.count = None, 0
        self.subscriber = rospy.Subscriber(topic, kind, self._on_message, queue_size=100)

    def _on_message(self, message):
        self.message = message
        self.count += 1


def wait_for(condition, what, timeout_s=TIMEOUT_S):
    end = time.time() + timeout_s
    while not condition():
        if time.time() > end:
            raise AssertionError("timed out waiting for " + what)
        time.sleep(0.02)


def service(name, kind):
    rospy.wait_for_service(name, TIMEOUT_S)
    return rospy.ServiceProxy(name, kind)


def reference(x, y, z, heading=0.0):
    out = Reference()
    out.position.x, out.position.y, out.position.z, out.heading = x, y, z, heading
    return out


def distance(a, b):
    return math.sqrt((a.x - b.x) ** 2 + (a.y - b.y) ** 2 + (a.z - b.z) ** 2)


class UavSimulatorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.clock = Latest("/clock", Clock)
        cls.state = Latest("estimation_manager/uav_state", UavState)
        cls.odom = Latest("estimation_manager/odom_main", Odometry)
        cls.truth = Latest("uav_simulator/ground_truth", Odometry)
        cls.imu = Latest("hw_api/imu", Imu)
        cls.command = Latest("control_manager/tracker_cmd", TrackerCommand)
        cls.control = Latest("control_manager/diagnostics", ControlManagerDiagnostics)
        cls.constraints = Latest("control_manager/current_constraints", DynamicsConstraints)
        cls.tf = Latest("/tf", TFMessage)
        cls.reports = rospy.Publisher("progress", Progress, queue_size=100)
        cls.is_reporting = False
        cls.reporter = threading.Thread(target=cls.report, daemon=True)
        every = (cls.state, cls.odom, cls.truth, cls.imu, cls.command, cls.control, cls.constraints, cls.tf)
        wait_for(lambda: all(latest.count > 0 for latest in every), "the simulator")

    @classmethod
    def report(cls):
        while not rospy.is_shutdown():
            if cls.is_reporting:
                try:
                    cls.reports.publish(Progress(node="planner", stamp=cls.clock.message.clock))
                except rospy.ROSException:
                    return  # ROS is shutting down
            time.sleep(0.005)

    def position(self):
        return self.state.message.pose.position

    def test_1_names_frames_and_prediction(self):
        self.assertEqual(self.state.message.header.frame_id, "uav1/gps_garmin_origin")
        self.assertEqual(self.truth.message.header.frame_id, "uav1/ground_truth_origin")
        self.assertEqual(self.odom.message.child_frame_id, "uav1/fcu")
        self.assertAlmostEqual(self.constraints.message.horizontal_speed, 4.0)
        prediction = self.command.message.full_state_prediction
        self.assertEqual(len(prediction.position), 40)
        ahead = [(s - prediction.header.stamp).to_sec() for s in prediction.stamps]
        self.assertAlmostEqual(ahead[0], 0.01, 6)
        self.assertAlmostEqual(ahead[39], 7.81, 6)
        parents = {t.child_frame_id: t.header.frame_id for t in self.tf.message.transforms}
        self.assertNotIn("uav1/fcu", parents)
        self.assertEqual(parents["uav1/gps_garmin_origin"], "uav1/fcu")
        self.assertEqual(parents["uav1/ground_truth_origin"], "uav1/fcu")

    def test_2_refuses_on_the_ground(self):
        answer = service("control_manager/goto", Vec4)([1, 2, 3, 0])
        self.assertFalse(answer.success)
        self.assertIn("not flying", answer.message)
        answer = service("uav_manager/takeoff", Trigger)()
        self.assertFalse(answer.success)
        self.assertIn("planner", answer.message)

    def test_3_takes_off_once_the_planner_reports(self):
        cls = type(self)
        cls.is_reporting = True
        cls.reporter.start()
        takeoff = service("uav_manager/takeoff", Trigger)
        wait_for(lambda: takeoff().success, "take-off to be accepted")
        wait_for(lambda: self.control.message.flying_normally, "flying normally")
        self.assertAlmostEqual(self.position().z, 2.0, delta=0.3)

    def test_4_flies_a_generated_path(self):
        path = Path()
        path.points = [reference(8, 0, 3), reference(8, 8, 3, 1.0)]
        path.use_heading = path.fly_now = True
        path.max_deviation_from_path = 0.2
        generated = service("trajectory_generation/get_path", GetPathSrv)(path)
        self.assertTrue(generated.success, generated.message)
        self.assertEqual(len(generated.waypoint_trajectory_idxs), 2)
        self.assertLess(distance(generated.trajectory.points[0].position, self.position()), 0.1)
        answer = service("control_manager/trajectory_reference", TrajectoryReferenceSrv)(generated.trajectory)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(list(answer.tracker_successes), [True])
        wait_for(lambda: self.control.message.tracker_status.tracking_trajectory, "tracking")
        start = self.position()
        wait_for(lambda: distance(start, self.position()) > 1.5, "flight")
        self.continue_in_flight()
        wait_for(lambda: not self.control.message.tracker_status.have_goal, "arrival")
        self.assertLess(distance(self.position(), path.points[-1].position), 0.1)

    def continue_in_flight(self):
        """Asks for a path that starts in the future, whose trajectory must begin with the prediction."""
        path = Path()
        path.header.stamp = rospy.Time.now() + rospy.Duration(2.0)
        path.points = [reference(8, 0, 3), reference(8, 8, 3, 1.0)]
        path.use_heading = path.fly_now = True
        path.max_deviation_from_path = 0.2
        generated = service("trajectory_generation/get_path", GetPathSrv)(path)
        self.assertTrue(generated.success, generated.message)
        points = [p.position for p in generated.trajectory.points]
        self.assertAlmostEqual(generated.trajectory.dt, 0.2)
        steps = [distance(a, b) for a, b in zip(points, points[1:])]
        self.assertLess(max(steps) / 0.2, 4.5)  # the speed shows no jump where the prediction ends
        answer = service("control_manager/trajectory_reference", TrajectoryReferenceSrv)(generated.trajectory)
        self.assertTrue(answer.success, answer.message)

    def test_5_refusals_name_the_reason(self):
        fly = service("control_manager/trajectory_reference", TrajectoryReferenceSrv)
        self.assertIn("empty", fly(TrajectoryReference(fly_now=True)).message)
        bad = TrajectoryReference(fly_now=True, points=[reference(0, float("nan"), 3)])
        answer = fly(bad)
        self.assertFalse(answer.success)
        self.assertIn("not finite", answer.message)
        self.assertEqual(list(answer.tracker_successes), [False])
        lost = TrajectoryReference(fly_now=True, points=[reference(0, 0, 3)])
        lost.header.frame_id = "uav1/nowhere"
        self.assertIn("no transform", fly(lost).message)
        old = TrajectoryReference(fly_now=True, points=[reference(0, 0, 3)] * 3)
        old.header.stamp = rospy.Time.now() - rospy.Duration(5.0)
        self.assertIn("over", fly(old).message)
        self.assertFalse(service("constraint_manager/set_constraints", String)("warp").success)
        self.assertFalse(service("trajectory_generation/get_path", GetPathSrv)(Path()).success)

    def test_6_constraints_goals_in_body_frame_and_hover(self):
        self.assertTrue(service("constraint_manager/set_constraints", String)("slow").success)
        wait_for(lambda: self.constraints.message.horizontal_speed == 1.0, "slow constraints")
        goto = service("control_manager/reference", ReferenceStampedSrv)
        before = self.position()
        header = self.state.message.header
        header.frame_id = "fcu"
        self.assertTrue(goto(header, reference(6, 0, 0)).success)
        wait_for(lambda: distance(before, self.position()) > 1.0, "the way to the goal")
        self.assertTrue(self.control.message.tracker_status.callbacks_enabled)
        self.assertTrue(service("control_manager/hover", Trigger)().success)
        wait_for(lambda: not self.control.message.tracker_status.callbacks_enabled, "callbacks taken while braking")
        wait_for(lambda: abs(self.state.message.velocity.linear.x) + abs(self.state.message.velocity.linear.y) < 0.03,
                 "standing still")
        self.assertLess(distance(before, self.position()), 5.0)

    def test_6b_the_estimator_is_switched_and_everything_comes_in_the_other_origin(self):
        change = service("estimation_manager/change_estimator", String)
        self.assertIn("no estimator", change("vio").message)
        self.assertIn("active already", change("gps_garmin").message)
        before, iteration = self.position(), self.state.message.estimator_iteration
        self.assertTrue(change("gps_baro").success)
        in_control = (self.state, self.odom, self.command)
        wait_for(lambda: all(each.message.header.frame_id == "uav1/gps_baro_origin" for each in in_control), "a switch")
        self.assertEqual(self.state.message.estimator_iteration, iteration + 1)
        for p in (self.position(), self.odom.message.pose.pose.position, self.command.message.position,
                  self.command.message.full_state_prediction.position[0]):
            # The other origin is at (3, -2, 1) with heading 0.3 in the first one. The vehicle has not moved.
            x = 3.0 + math.cos(0.3) * p.x - math.sin(0.3) * p.y
            y = -2.0 + math.sin(0.3) * p.x + math.cos(0.3) * p.y
            self.assertLess(math.sqrt((x - before.x) ** 2 + (y - before.y) ** 2 + (p.z + 1.0 - before.z) ** 2), 0.2)
        here = self.expressed("uav1/gps_baro_origin", self.position(), "gps_garmin_origin")
        self.assertLess(distance(here, before), 0.2)

    def expressed(self, frame, p, to):
        msg = ReferenceStamped(reference=reference(p.x, p.y, p.z))
        msg.header.frame_id = frame
        answer = service("control_manager/transform_reference", TransformReferenceSrv)(to, msg)
        self.assertTrue(answer.success, answer.message)
        return answer.reference.reference.position

    def test_6c_places_on_earth_are_transformed(self):
        there = self.expressed("latlon_origin", Point(49.3625 + 1e-3, 14.2613, 7.0), "world_origin")
        self.assertLess(distance(there, Point(0.0, 111.3, 7.0)), 0.1)

    def test_6d_references_are_validated_against_the_safety_area(self):
        """The area is a square of 400 m, from -100 m to 90 m of height; no straight way within it leaves it."""
        for name, is_high_valid in (("validate_reference", False), ("validate_reference_2d", True)):
            validate = service("control_manager/" + name, ValidateReference)

            def answer(place, frame="world_origin"):
                msg = ReferenceStamped(reference=reference(*place))
                msg.header.frame_id = frame
                return validate(msg)
            self.assertEqual(answer((20, 0, 3)).message, "the reference is ok")
            self.assertTrue(answer((20, 0, 3)).success)
            self.assertEqual(answer((220, 0, 3)).message, "the point is outside of the safety area")
            self.assertEqual(answer((20, 0, 95)).success, is_high_valid)
            self.assertEqual(answer((20, float("nan"), 3)).message, "NaNs/infs in input!")
            self.assertEqual(answer((20, 0, 3), "nowhere").message, "the reference could not be transformed")
        many = service("control_manager/validate_reference_array", ValidateReferenceArray)
        request = ValidateReferenceArrayRequest()
        request.array.header.frame_id = "world_origin"
        request.array.array = [reference(20, 0, 3), reference(220, 0, 3), reference(20, 0, 95)]
        self.assertEqual(list(many(request).success), [True, False, False])
        request.array.header.frame_id = "nowhere"
        with self.assertRaises(rospy.ServiceException):
            many(request)

    def test_6e_an_emergency_hover_lasts_until_a_person_ends_it(self):
        goto = service("control_manager/goto_relative", Vec4)
        self.assertTrue(service("control_manager/ehover", Trigger)().success)
        wait_for(lambda: self.control.message.active_controller == "EmergencyController", "the emergency hover")
        said = self.control.message
        self.assertEqual(said.active_tracker, "LandoffTracker")
        self.assertTrue(said.output_enabled and not said.flying_normally)
        self.assertFalse(said.tracker_status.callbacks_enabled)
        self.assertFalse(goto([1.0, 0.0, 0.0, 0.0]).success)
        self.assertIn("does not implement", service("control_manager/hover", Trigger)().message)
        self.assertFalse(service("control_manager/switch_tracker", String)("NullTracker").success)
        self.assertTrue(service("control_manager/switch_tracker", String)("MpcTracker").success)
        self.assertTrue(service("control_manager/switch_controller", String)("Se3Controller").success)
        self.assertFalse(goto([1.0, 0.0, 0.0, 0.0]).success)
        self.assertTrue(service("control_manager/enable_callbacks", SetBool)(True).success)
        wait_for(lambda: self.control.message.flying_normally, "normal flight")
        self.assertTrue(goto([1.0, 0.0, 0.0, 0.0]).success)

    def test_7_time_waits_for_the_planner_but_not_for_ever(self):
        cls = type(self)
        cls.is_reporting = False
        stopped = self.stopped_clock()
        self.assertTrue(service("control_manager/hover", Trigger)().success)  # services work while time stands still
        self.assertEqual(self.clock.message.clock, stopped)
        wait_for(lambda: (self.clock.message.clock - stopped).to_sec() > 0.5, "time to go on without the planner")

    def stopped_clock(self):
        """Returns the simulated time once it has not changed for a second of wall time."""
        value, since = self.clock.message.clock, time.time()
        end = since + TIMEOUT_S
        while time.time() < min(end, since + 1.0):
            if self.clock.message.clock != value:
                value, since = self.clock.message.clock, time.time()
            time.sleep(0.02)
        self.assertLess(time.time(), end, "time never stood still")
        return value

    def test_8_lands(self):
        type(self).is_reporting = True
        self.assertTrue(service("uav_manager/land", Trigger)().success)
        wait_for(lambda: not self.control.message.output_enabled, "landing")
        self.assertFalse(service("control_manager/hover", Trigger)().success)
        self.assertIn("while not flying", service("control_manager/eland", Trigger)().message)

    def test_8b_emergency_landing_and_failsafe_end_on_the_ground(self):
        for name, tracker, controller in (("eland", "LandoffTracker", "EmergencyController"),
                                          ("failsafe", "MpcTracker", "FailsafeController")):
            self.assertTrue(service("uav_manager/takeoff", Trigger)().success)
            wait_for(lambda: self.control.message.flying_normally, "take-off")
            self.assertTrue(service("control_manager/" + name, Trigger)().success)
            wait_for(lambda: not self.control.message.flying_normally, name)
            said = self.control.message
            self.assertEqual((said.active_tracker, said.active_controller), (tracker, controller))
            is_landing = said.tracker_status.state == said.tracker_status.STATE_LAND
            self.assertEqual(is_landing, name == "eland")  # the failsafe leaves the tracker as it is
            self.assertIn("already triggered", service("control_manager/" + name, Trigger)().message)
            wait_for(lambda: not self.control.message.output_enabled, "the end of " + name)

    def test_9_imu_rate(self):
        stamps = []
        subscriber = rospy.Subscriber("hw_api/imu", Imu, lambda imu: stamps.append(imu.header.stamp), queue_size=1000)
        wait_for(lambda: len(stamps) > 400, "IMU messages")
        subscriber.unregister()
        # Intervals are checked rather than the number of messages, because some may be lost on a loaded machine.
        steps_s = sorted((later - earlier).to_sec() for earlier, later in zip(stamps, stamps[1:]))
        self.assertAlmostEqual(steps_s[0], 0.005, places=6)
        self.assertAlmostEqual(steps_s[len(steps_s) // 2], 0.005, places=6)


if __name__ == "__main__":
    rospy.init_node("uav_simulator_test")
    rostest.rosrun("voxnav", "uav_simulator_test", UavSimulatorTest, sys.argv)
