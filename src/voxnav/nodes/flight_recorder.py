# SPDX-License-Identifier: BSD-3-Clause
"""Flies one mission (take off, go to a goal) and records it."""

import os
import threading
import time

import numpy as np
import rospy
from mrs_msgs.msg import ControlManagerDiagnostics
from mrs_msgs.srv import ReferenceStampedSrv, ReferenceStampedSrvRequest, String
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger

import voxnav
from voxnav.msg import Clearance, NodeDiagnostics, PlannerStatus, SubmapPoses
from voxnav.nodes.clouds import points_from_msg
from voxnav.nodes.poses import pose_from_msg
from voxnav.nodes.time_leader import ANSWER_LIMIT_S

TRAJECTORY = "submap_optimizer/trajectory"
NODES = ("uav_simulator", "lidar_simulator", "cloud_filter", "local_mapper", "submap_integrator", "submap_optimizer",
         "planning_manager")

FINAL_DIAGNOSTICS_S = 5.0
# In lock-step this is the simulated time between two checks of the flight, and the wall time for nodes to connect.
LEADER_STEP_S = 0.5
CONNECTION_S = 3.0
# Lock-step lets half a second pass at once, so the queues must hold the messages of that time.
TRACK_QUEUE = 1000
WARM_UP_STEPS = 4
COUNTERS = ("num_hovers", "num_shortened")  # of PlannerStatus and of FlightRecord


class MissionError(RuntimeError):
    """The mission could not go on; the text says why."""


class FlightRecorder:
    """Subscribes below the UAV's namespace and fills a voxnav.demo.record.FlightRecord."""

    def __init__(self, record, nodes=NODES, odometry_topic="estimation_manager/odom_main", leader=None):
        """Subscribes. leader: the TimeLeader of a lock-step simulation, or None if time runs by itself."""
        self.record, self._expected, self._leader = record, nodes, leader
        self._lock = threading.Lock()
        self._nodes, self._status, self._control = {}, None, None
        self._obstacles = None
        self._dropped_before = {}
        self.speed_mps = 0.0
        self.reasons = []  # the reasons of the planner in order, without repetitions in a row
        rospy.Subscriber("uav_simulator/ground_truth", Odometry, self._on_truth, queue_size=TRACK_QUEUE)
        self._odometry_frame = None
        rospy.Subscriber(odometry_topic, Odometry, self._on_estimate, queue_size=TRACK_QUEUE)
        self._trajectory = rospy.Subscriber(TRAJECTORY, Path, self._on_trajectory, queue_size=1)
        rospy.Subscriber("uav_simulator/clearance", Clearance, self._on_clearance, queue_size=TRACK_QUEUE)
        rospy.Subscriber("planning_manager/status", PlannerStatus, self._on_status, queue_size=5)
        rospy.Subscriber("control_manager/diagnostics", ControlManagerDiagnostics, self._on_control, queue_size=5)
        rospy.Subscriber("submap_integrator/obstacle_cloud", PointCloud2, self._on_cloud, queue_size=1)
        for node in nodes:
            rospy.Subscriber(node + "/diagnostics", NodeDiagnostics, self._on_diagnostics, queue_size=2)

    def _on_odometry(self, track):
        def callback(msg):
            p = msg.pose.pose.position
            with self._lock:
                track.add(msg.header.stamp.to_sec(), (p.x, p.y, p.z))
        return callback

    def _on_estimate(self, msg):
        """Records the estimate until its origin is another one, since positions there have nothing to do with these."""
        self._odometry_frame = self._odometry_frame or msg.header.frame_id
        if msg.header.frame_id == self._odometry_frame:
            self._on_odometry(self.record.odometry_track)(msg)

    def _on_truth(self, msg):
        v = msg.twist.twist.linear
        self.speed_mps = float(np.linalg.norm((v.x, v.y, v.z)))
        self._on_odometry(self.record.truth_track)(msg)

    def _on_trajectory(self, msg):
        stamps = np.array([pose.header.stamp.to_sec() for pose in msg.poses])
        poses = np.array([pose_from_msg(stamped.pose) for stamped in msg.poses]).reshape(-1, 4, 4)
        with self._lock:
            self.record.optimised, self.record.optimised_poses = (stamps, poses[:, :3, 3]), poses

    def _on_clearance(self, msg):
        with self._lock:
            if self.record.mission is not None and msg.header.stamp.to_sec() <= self.record.mission[1]:
                known = self.record.min_clearance_m
                self.record.min_clearance_m = msg.clearance_m if known is None else min(known, msg.clearance_m)
                self.record.has_collided = bool(msg.has_collided)

    def _on_status(self, msg):
        with self._lock:
            if self._status is None or self._status.reason != msg.reason:
                rospy.loginfo("planning manager: %s", msg.reason)
                self.reasons.append(msg.reason)
            for name in COUNTERS:
                self._count(name, msg)
            self._status = msg

    def _count(self, name, msg):
        """Adds what a counter of the planner grew by; a planner that was started anew counts from zero again."""
        value, last = getattr(msg, name), 0 if self._status is None else getattr(self._status, name)
        known = getattr(self.record, name) or 0
        setattr(self.record, name, known + (value - last if value >= last else value))

    def _on_control(self, msg):
        with self._lock:
            self._control = msg

    def _on_cloud(self, msg):
        with self._lock:
            self._obstacles = msg

    def _on_diagnostics(self, msg):
        with self._lock:
            self._nodes[msg.node] = msg

    @property
    def status(self):
        """Returns the newest PlannerStatus, or None."""
        return self._status

    def wait_until(self, condition, timeout_s, what):
        """Waits until condition() is true. Raises MissionError naming what was awaited.

        The limit is of wall time. While this node leads time it is of simulated time, so that it does not depend on the
        machine.
        """
        waited_s = 0.0
        while not rospy.is_shutdown():
            with self._lock:
                if condition():
                    return
            if waited_s > timeout_s:
                raise MissionError("waited %.0f s in vain for %s" % (timeout_s, what))
            if self._is_leading():
                self._let_time_run()
                waited_s += LEADER_STEP_S
            else:
                before_s = time.monotonic()
                time.sleep(0.05)
                waited_s += time.monotonic() - before_s
        raise MissionError("interrupted while waiting for %s" % what)

    def _is_leading(self):
        return self._leader is not None and self._leader.is_leading

    def _let_time_run(self):
        """Lets time run one step further in lock-step, until the planner has published its status of that instant."""
        deadline = time.monotonic() + ANSWER_LIMIT_S
        try:
            now_s = self._leader.run_for(LEADER_STEP_S)
        except TimeoutError as error:
            raise MissionError(str(error))
        while self._status is not None and self._status.header.stamp.to_sec() < now_s - 1e-3:
            if time.monotonic() > deadline or rospy.is_shutdown():
                raise MissionError("the planner does not keep up with lock-step")
            time.sleep(0.002)

    def wait_for_nodes(self, timeout_s):
        deadline = time.monotonic() + timeout_s
        while not all(node in self._nodes for node in self._expected):
            if time.monotonic() > deadline or rospy.is_shutdown():
                missing = [node for node in self._expected if node not in self._nodes]
                raise MissionError("waited %.0f s in vain for nodes: not heard %s" % (timeout_s, ", ".join(missing)))
            time.sleep(0.05)
        if self._is_leading():
            time.sleep(CONNECTION_S)

    def take_off(self, timeout_s):
        rospy.wait_for_service("uav_manager/takeoff", timeout_s)
        take_off = rospy.ServiceProxy("uav_manager/takeoff", Trigger)
        if self._is_leading():
            for _ in range(WARM_UP_STEPS):
                self._let_time_run()
        deadline = time.monotonic() + timeout_s
        response = take_off()
        # A step is refused while nodes for which lock-step waits are still starting.
        while not response.success and time.monotonic() < deadline:
            time.sleep(0.5)
            response = take_off()
        if not response.success:
            raise MissionError("take-off refused: " + response.message)
        self.wait_until(lambda: self._control is not None and self._control.flying_normally, timeout_s, "take-off")

    def send_goal(self, frame, goal):
        """Sends a goal (3,) and waits until the planner has taken it. The mission begins with the first goal."""
        request = ReferenceStampedSrvRequest()
        request.header.frame_id = frame
        request.reference.position.x, request.reference.position.y, request.reference.position.z = goal
        self.record.goal = tuple(goal)
        rospy.wait_for_service("planning_manager/reference", 10.0)
        with self._lock:
            if self.record.mission is None:
                start_s = self._leader.now_s if self._is_leading() else self._newest_truth()
                self.record.mission = (start_s, float("inf"))
                self._dropped_before = self._dropped(self._nodes)
        response = rospy.ServiceProxy("planning_manager/reference", ReferenceStampedSrv)(request)
        if not response.success:
            raise MissionError("goal refused: " + response.message)
        self.wait_until(lambda: self._status is not None and self._status.has_goal, 10.0,
                        "the planner to take the goal")

    def fly_to(self, frame, goal, timeout_s, limit_s=None):
        """Sends the goal and waits until it is reached or given up.

        timeout_s: limit as of wait_until(); limit_s: simulated time after which the flight counts as not successful, or
        None.
        """
        self.send_goal(frame, goal)
        end_s = float("inf") if limit_s is None else self.record.mission[0] + limit_s

        def is_over():
            return not self._status.has_goal or self._status.header.stamp.to_sec() >= end_s
        try:
            self.wait_until(is_over, timeout_s, "the goal to be reached")
        finally:
            with self._lock:
                self.record.mission = (self.record.mission[0], self._status.header.stamp.to_sec())
                self.record.reached = bool(self._status.is_goal_reached)
                self.record.reason = self._status.reason
                if self._status.has_goal and self._status.header.stamp.to_sec() >= end_s:
                    self.record.reason = "not reached within %g s; last: %s" % (limit_s, self._status.reason)

    def _newest_truth(self):
        stamps, _ = self.record.truth_track.arrays()
        return float(stamps[-1]) if len(stamps) else 0.0

    def optimise(self, timeout_s):
        """Requests a last solve, so that the whole flight is in the map; its trajectory is the one that is kept."""
        try:
            rospy.wait_for_service("submap_optimizer/optimize", timeout_s)
            rospy.ServiceProxy("submap_optimizer/optimize", Trigger)()
            # The topic is latched: a new subscriber gets the last message, and none that is still on its way to others.
            self._trajectory.unregister()
            self._on_trajectory(rospy.wait_for_message(TRAJECTORY, Path, timeout_s))
        except (rospy.ROSException, rospy.ServiceException) as error:
            rospy.logwarn("no final optimisation: %s", error)

    def wait_for_map(self, timeout_s):
        """Waits until the map has taken over the poses of the last solve."""
        revision = rospy.wait_for_message("submap_optimizer/submap_poses", SubmapPoses, timeout_s).revision

        def has_taken():
            said = self._nodes.get("submap_integrator")
            return said and dict(zip(said.counter_names, said.counter_values)).get("graph_revision", 0) >= revision
        self.wait_until(has_taken, timeout_s, "the map to take the poses of the last solve")

    def save_map(self, directory):
        """Saves the global map to a folder, and its surface to the record; logs a failure."""
        try:
            rospy.wait_for_service("submap_integrator/save", 5.0)
            answer = rospy.ServiceProxy("submap_integrator/save", String)(os.path.abspath(directory))
            if not answer.success:
                raise MissionError(answer.message)
            self.record.surface_points = voxnav.SubmapCollection.load(directory).occupied_points()
        except (MissionError, ValueError, RuntimeError, rospy.ROSException, rospy.ServiceException) as error:
            rospy.logwarn("the map was not saved: %s", error)

    @staticmethod
    def _dropped(nodes):
        return {"%s/%s" % (node, stage.name): stage.dropped for node, msg in nodes.items() for stage in msg.stages}

    def finish(self):
        """Copies the newest diagnostics and clouds into the record."""
        with self._lock:
            nodes, self._nodes = self._nodes, {}
        try:  # messages from now on count everything that happened until now
            self.wait_until(lambda: all(node in self._nodes for node in self._expected), FINAL_DIAGNOSTICS_S, "them")
        except MissionError:
            pass  # of a silent node only its earlier diagnostics are left
        with self._lock:
            nodes, obstacles = dict(nodes, **self._nodes), self._obstacles
        for stage, count in self._dropped(nodes).items():
            # Before the flight, scans may come before the first pose.
            self.record.dropped_in_flight[stage] = max(0, count - self._dropped_before.get(stage, 0))
        for node, msg in nodes.items():
            self.record.rss_mb[node] = msg.rss_bytes / 1e6
            for stage in msg.stages:
                fields = ("mean_ms", "p99_ms", "max_ms", "cpu_ms", "dropped", "count", "latency_mean_ms",
                          "latency_p99_ms")
                self.record.stages[node + "/" + stage.name] = {f: getattr(stage, f) for f in fields}
            counters = dict(zip(msg.counter_names, msg.counter_values))
            if node == "uav_simulator":
                self.record.real_time_factor = counters.get("real_time_factor")
        if obstacles is not None:
            self.record.obstacle_points = points_from_msg(obstacles)
