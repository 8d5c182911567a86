#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The planning_manager node flies with a fake MRS system and a fake local map, and reacts to their faults."""

import sys
import threading
import time
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import PoseStamped, TransformStamped
from mrs_msgs.msg import (ControlManagerDiagnostics, DynamicsConstraints, MpcPredictionFullState, TrackerCommand,
                          TrackerStatus)
from mrs_msgs.srv import (GetPathSrv, GetPathSrvResponse, ReferenceStampedSrv, ReferenceStampedSrvRequest,
                          TrajectoryReferenceSrv, TrajectoryReferenceSrvResponse, TransformReferenceSrv,
                          TransformReferenceSrvResponse, Vec4, Vec4Request)
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger, TriggerResponse

import voxnav
from voxnav.msg import GridUpdate, NodeDiagnostics, PlannerStatus
from voxnav.nodes.planning_services import reference
from voxnav.srv import GetGrid, GetGridResponse

UAV = "/uav1/"
O, W = "uav1/odom", "uav1/voxnav_map"
SHIFT = np.array([10.0, 0.0, 0.0])  # position of the origin of O in W
SPEED = 2.0


class FakeUav:
    """A vehicle with the topics and services of MRS that flies trajectories exactly, and a free box as local map."""

    def __init__(self):
        self.lock = threading.RLock()
        self.position, self.flown = np.array([0.0, 0.0, 3.0]), None
        self.map_is_alive, self.generator_works = True, threading.Event()
        self.generator_works.set()
        self.num_hovers, self.num_ehovers, self.sequence = 0, 0, 0
        self.accepts_hover, self.stamps = True, []  # stamps of the trajectories that came
        self.input_id, self.is_cut = 0, False  # of the last trajectory; whether a safety area cuts the next one
        self.frame, self.paths = O, []  # the frame of the vehicle, and the paths that the generator was asked for
        self.grid = voxnav.StateGrid.from_array(np.ones((100, 60, 25), dtype=np.int8), (-8.0, -12.0, 0.0), 0.4)
        pub = rospy.Publisher
        self.odometry = pub(UAV + "estimation_manager/odom_main", Odometry, queue_size=5)
        self.tracker = pub(UAV + "control_manager/tracker_cmd", TrackerCommand, queue_size=5)
        self.control = pub(UAV + "control_manager/diagnostics", ControlManagerDiagnostics, queue_size=5)
        self.constraints = pub(UAV + "control_manager/current_constraints", DynamicsConstraints, queue_size=5)
        self.map = pub(UAV + "local_mapper/map", GridUpdate, queue_size=5)
        self.heartbeat = pub(UAV + "local_mapper/diagnostics", NodeDiagnostics, queue_size=5)
        rospy.Service(UAV + "trajectory_generation/get_path", GetPathSrv, self.serve_path)
        rospy.Service(UAV + "control_manager/trajectory_reference", TrajectoryReferenceSrv, self.serve_trajectory)
        rospy.Service(UAV + "control_manager/hover", Trigger, self.serve_hover)
        rospy.Service(UAV + "control_manager/ehover", Trigger, self.serve_ehover)
        self.serve_map()
        tf = TransformStamped(child_frame_id=W)
        tf.header.frame_id, tf.transform.rotation.w = O, 1.0
        tf.transform.translation.x = -SHIFT[0]
        self.broadcaster = tf2_ros.StaticTransformBroadcaster()
        self.broadcaster.sendTransform(tf)
        threading.Thread(target=self.run, daemon=True).start()

    def serve_map(self):
        self.map_service = rospy.Service(UAV + "local_mapper/get_map", GetGrid,
                                         lambda _: GetGridResponse(True, "", self.snapshot()))

    def position_at(self, stamp_s):
        if self.flown is None:
            return self.position
        points, dt, begin = self.flown
        at = min(max((stamp_s - begin) / dt, 0.0), len(points) - 1.0)
        low = int(at)
        return points[low] + (at - low) * (points[min(low + 1, len(points) - 1)] - points[low])

    def ends_s(self):
        points, dt, begin = self.flown
        return begin + dt * (len(points) - 1)

    def snapshot(self):
        data = self.grid.snapshot()
        msg = GridUpdate(sequence=self.sequence, is_snapshot=True, resolution_m=0.4, states=data["states"],
                         block_indices=data["block_indices"].ravel().tolist())
        msg.header.stamp, msg.header.frame_id = rospy.Time.now(), O
        return msg

    def run(self):
        for count in range(10 ** 9):
            time.sleep(0.05)
            if rospy.is_shutdown():
                return
            try:
                with self.lock:
                    self.publish(rospy.Time.now(), count)
            except rospy.ROSException:
                return  # ROS is shutting down

    def publish(self, now, count):
        before, self.position = self.position, self.position_at(now.to_sec())
        odometry = Odometry()
        odometry.header.stamp, odometry.header.frame_id = now, self.frame
        p, v = odometry.pose.pose.position, odometry.twist.twist.linear
        p.x, p.y, p.z = self.position
        v.x, v.y, v.z = (self.position - before) / 0.05
        odometry.pose.pose.orientation.w = 1.0
        self.odometry.publish(odometry)
        prediction = MpcPredictionFullState(input_id=self.input_id)
        stamps = [now + rospy.Duration(0.01 + 0.2 * i) for i in range(40)]
        prediction.stamps = stamps
        prediction.position = [reference(self.position_at(s.to_sec()), 0.0).position for s in stamps]
        command = TrackerCommand(use_full_state_prediction=1, full_state_prediction=prediction)
        command.header.stamp, command.header.frame_id = now, O
        self.tracker.publish(command)
        if count % 2 == 0 and self.map_is_alive:
            self.publish_map(now)
        if count % 10 == 0:
            self.publish_slow(now)

    def publish_map(self, now):
        self.sequence += 1
        msg = self.snapshot() if self.sequence == 1 else GridUpdate(sequence=self.sequence, resolution_m=0.4)
        msg.header.stamp, msg.header.frame_id = now, O
        self.map.publish(msg)
        self.heartbeat.publish(NodeDiagnostics(node="local_mapper"))

    def publish_slow(self, now):
        control = ControlManagerDiagnostics(stamp=now, flying_normally=True, output_enabled=True)
        tracker = control.tracker_status
        tracker.callbacks_enabled, tracker.state = True, TrackerStatus.STATE_HOVER
        tracker.tracking_trajectory = self.flown is not None and now.to_sec() < self.ends_s()
        self.control.publish(control)
        limits = DynamicsConstraints()
        for name in ("horizontal", "vertical_ascending", "vertical_descending"):
            setattr(limits, name + "_speed", SPEED)
            setattr(limits, name + "_acceleration", 1.0)
        self.constraints.publish(limits)

    def serve_path(self, request):
        self.generator_works.wait()
        self.paths.append(request.path)
        now = rospy.Time.now().to_sec()
        line = [self.position_at(now)] + [np.array([p.position.x, p.position.y, p.position.z])
                                          for p in request.path.points]
        arcs = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        out = GetPathSrvResponse(success=True)
        out.trajectory.header.stamp = rospy.Time.from_sec(now)
        out.trajectory.header.frame_id, out.trajectory.dt = request.path.header.frame_id, 0.2
        for s in np.append(np.arange(0.0, arcs[-1], 0.2 * SPEED * 0.8), arcs[-1]):
            out.trajectory.points.append(reference([np.interp(s, arcs, np.array(line)[:, k]) for k in range(3)], 0.0))
        return out

    def serve_trajectory(self, request):
        points = np.array([(p.position.x, p.position.y, p.position.z) for p in request.trajectory.points])
        stamp = request.trajectory.header.stamp
        with self.lock:
            self.stamps.append(stamp)
            begin = rospy.Time.now() if stamp.is_zero() else stamp
            self.flown = (points[:len(points) // 2] if self.is_cut else points, request.trajectory.dt, begin.to_sec())
            self.input_id = request.trajectory.input_id
        return TrajectoryReferenceSrvResponse(success=True, modified=self.is_cut, tracker_names=["MpcTracker"],
                                              tracker_successes=[True])

    def serve_hover(self, _):
        with self.lock:
            self.num_hovers += 1
            if not self.accepts_hover:
                return TriggerResponse(False, "refused for the test")
            self.stop()
        return TriggerResponse(True, "")

    def serve_ehover(self, _):
        with self.lock:
            self.num_ehovers += 1
            self.stop()
        return TriggerResponse(True, "")

    def stop(self):
        self.position, self.flown = self.position_at(rospy.Time.now().to_sec()), None


class PlanningManagerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.uav, cls.status = FakeUav(), None
        rospy.Subscriber(UAV + "planning_manager/status", PlannerStatus, cls.on_status, queue_size=5)
        rospy.wait_for_service(UAV + "planning_manager/reference", 30.0)
        cls.reference = rospy.ServiceProxy(UAV + "planning_manager/reference", ReferenceStampedSrv)
        cls.stop = rospy.ServiceProxy(UAV + "planning_manager/stop", Trigger)

    @classmethod
    def on_status(cls, msg):
        cls.status = msg

    def wait(self, condition, timeout_s, what):
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            if self.status is not None and condition(self.status):
                return
            time.sleep(0.02)
        self.fail("waited in vain for %s; status: %s" % (what, self.status))

    def send(self, position, frame):
        request = ReferenceStampedSrvRequest()
        request.header.frame_id, request.reference = frame, reference(position, 0.0)
        deadline = time.monotonic() + 20.0
        while True:
            response = self.reference(request)
            if response.success or "no map correction" not in response.message or time.monotonic() > deadline:
                return response
            time.sleep(0.1)

    def assert_at(self, position):
        self.assertLess(np.linalg.norm(self.uav.position - position), 1.0)

    def test_1_flies_to_a_goal_in_the_map_frame(self):
        response = self.send((20.0, 4.0, 3.0), W)
        self.assertTrue(response.success, response.message)
        self.wait(lambda s: s.is_goal_reached, 40.0, "the goal")
        self.assert_at((10.0, 4.0, 3.0))
        self.assertEqual(self.status.header.frame_id, W)
        # The trajectory has the generator's stamp, so that the tracker skips what is over when it comes.
        self.assertTrue(self.uav.stamps)
        self.assertFalse(any(stamp.is_zero() for stamp in self.uav.stamps))

    def test_2_refuses_goals_that_are_none(self):
        self.assertEqual(self.send((float("nan"), 0.0, 3.0), W).message, "goal is not finite")
        self.assertIn("below", self.send((5.0, 0.0, -2.0), W).message)
        self.assertIn("no transform", self.send((5.0, 0.0, 3.0), "nowhere").message)

    def test_3_a_lost_map_leads_to_hover_and_the_flight_resumes(self):
        self.assertTrue(self.send((-4.0, 0.0, 3.0), O).success)
        self.wait(lambda s: s.state == PlannerStatus.MOVING, 20.0, "moving")
        hovers, self.uav.map_is_alive = self.uav.num_hovers, False
        self.wait(lambda s: s.state == PlannerStatus.IDLE and "local map lost" in s.reason, 10.0, "hover")
        self.wait(lambda s: self.uav.num_hovers > hovers, 5.0, "the hover service")
        self.assertTrue(self.status.has_goal)
        self.uav.map_is_alive = True
        self.wait(lambda s: s.is_goal_reached, 40.0, "the goal")
        self.assert_at((-4.0, 0.0, 3.0))

    def test_3b_a_hover_refused_in_motion_becomes_an_emergency_hover(self):
        self.assertTrue(self.send((10.0, 0.0, 3.0), O).success)
        self.wait(lambda s: s.state == PlannerStatus.MOVING, 20.0, "moving")
        self.wait(lambda s: self.uav.position[0] > 0.0, 20.0, "motion")
        self.uav.accepts_hover, self.uav.map_is_alive = False, False
        try:
            self.wait(lambda s: self.uav.num_ehovers == 1, 10.0, "the emergency hover")
            self.wait(lambda s: "local map lost; hover fails: refused for the test" in s.reason, 5.0, "the reason")
        finally:
            self.uav.accepts_hover, self.uav.map_is_alive = True, True
        self.wait(lambda s: s.is_goal_reached, 40.0, "the goal")

    def test_4_a_generator_that_hangs_is_named_and_does_not_hang_the_node(self):
        self.uav.generator_works.clear()
        goto = rospy.ServiceProxy(UAV + "planning_manager/goto", Vec4)
        self.assertTrue(goto(Vec4Request(goal=[4.0, 0.0, 3.0, 0.0])).success)
        self.wait(lambda s: "does not answer" in s.reason, 15.0, "a reason")
        self.assertTrue(self.stop().success)
        self.wait(lambda s: not s.has_goal, 5.0, "the stop")
        self.uav.generator_works.set()

    def test_5_a_click_in_rviz_keeps_the_altitude(self):
        publisher = rospy.Publisher(UAV + "planning_manager/goal", PoseStamped, queue_size=1, latch=True)
        goal = PoseStamped()
        goal.header.frame_id, goal.pose.position.x, goal.pose.orientation.w = W, 12.0, 1.0
        publisher.publish(goal)
        self.wait(lambda s: s.has_goal and abs(s.goal.z - 3.0) < 0.2, 10.0, "the goal to be taken")
        self.wait(lambda s: s.is_goal_reached, 40.0, "the goal")
        self.assert_at((2.0, 0.0, 3.0))

    def test_5b_a_path_without_a_heading_leaves_the_heading_free(self):
        """A goal without a heading sets relax_heading, because MRS would turn to the heading 0 of every waypoint."""
        del self.uav.paths[:]
        publisher = rospy.Publisher(UAV + "planning_manager/goal", PoseStamped, queue_size=1, latch=True)
        goal = PoseStamped()  # its quaternion is zero, which stands for no orientation
        goal.header.frame_id = W
        goal.pose.position.x, goal.pose.position.y, goal.pose.position.z = 6.0, 2.0, 3.0
        publisher.publish(goal)
        self.wait(lambda s: s.has_goal and abs(s.goal.y - 2.0) < 0.01, 10.0, "the goal to be taken")
        self.wait(lambda s: s.is_goal_reached, 40.0, "the goal")
        self.assert_at((-4.0, 2.0, 3.0))
        self.assertTrue(self.uav.paths)
        for path in self.uav.paths:
            self.assertFalse(path.use_heading)
            self.assertTrue(path.relax_heading)

    def test_5c_a_vehicle_in_another_frame_than_the_map_hovers(self):
        self.assertTrue(self.send((4.0, 0.0, 3.0), O).success)
        self.wait(lambda s: s.state == PlannerStatus.MOVING, 20.0, "moving")
        self.uav.frame = "uav1/other"
        self.wait(lambda s: "frame" in s.reason and s.state == PlannerStatus.IDLE, 10.0, "hover")
        self.uav.frame = O
        self.wait(lambda s: s.is_goal_reached, 40.0, "the goal")

    def test_5d_a_trajectory_that_is_cut_at_the_safety_area_ends_the_flight_and_says_so(self):
        self.uav.is_cut = True
        hovers = self.uav.num_hovers
        try:
            self.assertTrue(self.send((20.0, 0.0, 3.0), O).success)
            self.wait(lambda s: "safety area" in s.reason and not s.has_goal, 20.0, "the reason")
        finally:
            self.uav.is_cut = False
        self.wait(lambda s: self.uav.num_hovers > hovers, 5.0, "the hover service")

    def test_5e_a_goal_on_earth_is_transformed_by_the_control_manager(self):
        self.assertIn("transform_reference", self.send((50.1, 14.4, 3.0), "latlon_origin").message)
        asked = []

        def transform(request):
            asked.append((request.frame_id, request.reference.header.frame_id, request.reference.reference.position.y))
            out = TransformReferenceSrvResponse(success=True, reference=request.reference)
            out.reference.header.frame_id, out.reference.reference = request.frame_id, reference((4.0, 2.0, 3.0), 0.0)
            return out

        server = rospy.Service(UAV + "control_manager/transform_reference", TransformReferenceSrv, transform)
        try:
            for frame in ("latlon_origin", "uav1/latlon_origin"):
                self.assertTrue(self.send((50.1, 14.4, 3.0), frame).success)
                self.wait(lambda s: abs(s.goal.x - 14.0) < 0.01 and abs(s.goal.y - 2.0) < 0.01, 5.0, "the goal in W")
        finally:
            server.shutdown("test")
        self.assertEqual(asked, [(O, "latlon_origin", 14.4), (O, "uav1/latlon_origin", 14.4)])
        self.assertTrue(self.stop().success)

    def test_5f_empty_and_short_frames_are_those_of_mrs(self):
        # Goals are so far away that none is reached before the status shows it.
        for frame, x in (("", 18.0), ("odom", 18.0), ("uav1/odom", 18.0), ("voxnav_map", 8.0)):
            self.assertTrue(self.send((8.0, 0.0, 3.0), frame).success)
            self.wait(lambda s: s.has_goal and abs(s.goal.x - x) < 0.01, 5.0, "a goal in frame '%s'" % frame)
        self.assertTrue(self.stop().success)

    def test_6_changes_lost_without_a_map_service_lead_to_hover_until_it_is_there(self):
        self.assertTrue(self.send((16.0, 0.0, 3.0), O).success)
        self.wait(lambda s: s.state == PlannerStatus.MOVING, 20.0, "moving")
        self.uav.map_service.shutdown("test")
        with self.uav.lock:
            self.uav.sequence += 5
        self.wait(lambda s: s.state == PlannerStatus.IDLE and "local map lost" in s.reason, 10.0, "hover")
        self.assertTrue(self.status.has_goal)
        self.uav.serve_map()
        self.wait(lambda s: s.is_goal_reached, 40.0, "the goal")
        self.assert_at((16.0, 0.0, 3.0))


if __name__ == "__main__":
    rospy.init_node("planning_manager_test")
    rostest.rosrun("voxnav", "planning_manager", PlanningManagerTest, sys.argv)
