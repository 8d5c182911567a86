# SPDX-License-Identifier: BSD-3-Clause
"""Flies two simulated UAVs to goals of their own at the same time, and measures how near they come to each other."""

import threading
import time

import numpy as np
import rospy
from mrs_msgs.msg import ControlManagerDiagnostics
from mrs_msgs.srv import ReferenceStampedSrv, ReferenceStampedSrvRequest
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger

from voxnav.msg import Clearance, PlannerStatus

# Bodies of simulated UAVs have this radius.
BODY_M = 0.35
# Limits of wall time for starting; and for the flight, whose simulated time may run that much slower.
START_LIMIT_S, SLOWNESS = 180.0, 20.0
POLL_S = 0.05


class SimulatedVehicle:
    """What one of the UAVs says."""

    def __init__(self, name, on_truth):
        self.name, self.position, self.stamp_s = name, None, 0.0
        self.status = self.control = self.clearance = None
        self.begin_s = self.end_s = None
        self._on_truth = on_truth
        for topic, kind, take in (("uav_simulator/ground_truth", Odometry, self._take_truth),
                                  ("planning_manager/status", PlannerStatus, self._take("status")),
                                  ("control_manager/diagnostics", ControlManagerDiagnostics, self._take("control")),
                                  ("uav_simulator/clearance", Clearance, self._take("clearance"))):
            rospy.Subscriber("/%s/%s" % (name, topic), kind, take, queue_size=20)

    def _take(self, what):
        return lambda msg: setattr(self, what, msg)

    def _take_truth(self, msg):
        p = msg.pose.pose.position
        self.position, self.stamp_s = np.array([p.x, p.y, p.z]), msg.header.stamp.to_sec()
        self._on_truth()

    @property
    def is_flying(self):
        return self.control is not None and self.control.flying_normally

    @property
    def is_ready(self):
        """Whether the planner runs and has all its inputs: then it says that it has no goal."""
        return self.is_flying and self.status is not None

    def command(self, service, kind, request=None):
        rospy.wait_for_service("/%s/%s" % (self.name, service), START_LIMIT_S)
        proxy = rospy.ServiceProxy("/%s/%s" % (self.name, service), kind)
        return proxy() if request is None else proxy(request)

    def result(self):
        is_reached = self.status is not None and self.status.is_goal_reached and not self.status.has_goal
        return {"reached": bool(is_reached), "reason": "" if self.status is None else self.status.reason,
                "flight_s": (self.end_s or self.stamp_s) - (self.begin_s or self.stamp_s),
                "min_clearance_m": float("nan") if self.clearance is None else self.clearance.min_clearance_m,
                "num_hovers": 0 if self.status is None else self.status.num_hovers,
                "num_shortened": 0 if self.status is None else self.status.num_shortened,
                "end": None if self.position is None else self.position.tolist()}


class FlightOfTwo:
    """The flight, and the least distance between the middles of the vehicles while both fly to their goals."""

    def __init__(self, names):
        self._lock = threading.Lock()
        self._track, self._least = [], (float("inf"), 0.0)
        self.vehicles = []
        self.vehicles = [SimulatedVehicle(name, self._measure) for name in names]

    def _measure(self):
        with self._lock:
            if len(self.vehicles) < 2 or any(each.position is None or each.begin_s is None for each in self.vehicles):
                return
            first, second = self.vehicles
            distance_m = float(np.linalg.norm(first.position - second.position))
            stamp_s = max(first.stamp_s, second.stamp_s)
            self._least = min(self._least, (distance_m, stamp_s))
            if not self._track or stamp_s - self._track[-1][0] >= 0.2:
                self._track.append([stamp_s] + first.position.tolist() + second.position.tolist())

    def take_off(self):
        for vehicle in self.vehicles:
            deadline = time.monotonic() + START_LIMIT_S
            while not vehicle.command("uav_manager/takeoff", Trigger).success and time.monotonic() < deadline:
                time.sleep(0.5)  # of wall time: it is refused while nodes are still starting
        self._wait(lambda: all(each.is_ready for each in self.vehicles), START_LIMIT_S, "both to fly")

    def fly(self, goals, limit_s):
        for vehicle, goal in zip(self.vehicles, goals):
            request = ReferenceStampedSrvRequest()
            request.header.frame_id = vehicle.name + "/voxnav_map"
            position = request.reference.position
            position.x, position.y, position.z = goal
            deadline = time.monotonic() + START_LIMIT_S
            answer = vehicle.command("planning_manager/reference", ReferenceStampedSrv, request)
            while not answer.success and time.monotonic() < deadline:
                time.sleep(0.5)
                answer = vehicle.command("planning_manager/reference", ReferenceStampedSrv, request)
            self._wait(lambda: vehicle.status.has_goal, START_LIMIT_S, vehicle.name + " to take its goal")
            vehicle.begin_s = vehicle.stamp_s
        self._wait(lambda: self._are_over(limit_s), SLOWNESS * limit_s, "both to arrive")

    def _are_over(self, limit_s):
        for vehicle in self.vehicles:
            if vehicle.end_s is None and not vehicle.status.has_goal:
                vehicle.end_s = vehicle.stamp_s
        return all(each.end_s is not None or each.stamp_s - each.begin_s > limit_s for each in self.vehicles)

    @staticmethod
    def _wait(condition, timeout_s, what):
        deadline = time.monotonic() + timeout_s
        while not condition():
            if time.monotonic() > deadline or rospy.is_shutdown():
                raise TimeoutError("waited in vain for " + what)
            time.sleep(POLL_S)

    def result(self, problem):
        clearances = [each.clearance for each in self.vehicles]
        has_hit = any(each is not None and each.has_collided for each in clearances)
        return {"uavs": {each.name: each.result() for each in self.vehicles}, "problem": problem,
                "least_distance_m": self._least[0], "least_distance_at_s": self._least[1],
                "has_collided": bool(has_hit or self._least[0] < 2.0 * BODY_M), "track": self._track}


def fly(names, goals, limit_s):
    """Flies; on the master of the environment. goals: (3,) for each, in its map frame. Returns a dictionary."""
    rospy.init_node("two_uavs_mission", disable_signals=True)
    flight, problem = FlightOfTwo(names), ""
    try:
        flight.take_off()
        flight.fly(goals, limit_s)
    except (TimeoutError, rospy.ROSException, rospy.ServiceException) as error:
        problem = str(error)
        rospy.logerr("two UAVs: %s", problem)
    return flight.result(problem)
