# SPDX-License-Identifier: BSD-3-Clause
"""The services and diagnostics of mrs_octomap_planner under its names, which the planning manager answers."""

import threading

import rospy
from geometry_msgs.msg import Point
from mrs_modules_msgs.msg import OctomapPlannerDiagnostics
from mrs_msgs.srv import (ReferenceStampedSrv, ReferenceStampedSrvResponse, String, StringResponse,
                          ValidateReferenceArray, ValidateReferenceArrayResponse, Vec1, Vec1Response, Vec4,
                          Vec4Response)
from std_srvs.srv import Trigger, TriggerResponse

import voxnav
from voxnav.msg import NodeDiagnostics, PlannerStatus
from voxnav.nodes.node_base import Diagnostics, run_node
from voxnav.nodes.params import load_sections
from voxnav.nodes.planning_services import ServiceError, TimedService
from voxnav.nodes.time_seam import RealTime
from voxnav.srv import FindPath, FindPathResponse

NAME = "octomap_planner"
# The planners of mrs_octomap_planner, all of which voxnav's own stands in for.
PLANNERS = ("mrs", "subt")


def refused(response_class):
    """Returns what makes a response of the class out of a problem."""
    return lambda problem: response_class(success=False, message=problem)


class OctomapPlanner:
    def __init__(self):
        self._config, = load_sections(node=voxnav.OctomapPlannerConfig)
        self._diagnostics = Diagnostics(NAME)
        self._lock, self._num_refused = threading.Lock(), 0
        self._status = self._heard = None
        self._published = rospy.Publisher("~mrs_diagnostics_out", OctomapPlannerDiagnostics, queue_size=5)
        rospy.Subscriber("~status_in", PlannerStatus, self._on_status, queue_size=1)
        self._forward("goto", Vec4, refused(Vec4Response))
        self._forward("reference", ReferenceStampedSrv, refused(ReferenceStampedSrvResponse))
        self._forward("stop", Trigger, refused(TriggerResponse))
        self._forward("distance", Vec1, refused(Vec1Response), self._problem_of_distance)
        self._forward("altitude", Vec1, refused(Vec1Response))
        self._forward("add_virtual_obstacle", ValidateReferenceArray,
                      lambda problem: ValidateReferenceArrayResponse(success=[False], message=problem))
        self._forward("remove_virtual_obstacles", Trigger, refused(TriggerResponse))
        self._forward("get_path", FindPath, refused(FindPathResponse))
        rospy.Service("~set_planner", String, self._serve_set_planner)
        RealTime.every(self._config.diagnostics_rate_hz, self._publish)

    def _forward(self, name, service_class, refusal, problem_of=None):
        """Offers the service ~NAME, which passes requests on to ~NAME_out.

        refusal(problem) makes the response if there is none; problem_of(request) returns why it is not passed on, or ''
        """
        client = TimedService("~%s_out" % name, service_class, self._config.service_timeout_s, RealTime())

        def serve(request):
            problem = problem_of(request) if problem_of is not None else ""
            if not problem:
                try:
                    return client.call(request)
                except ServiceError as error:
                    problem = str(error)
            self._note_refusal("%s: %s" % (name, problem))
            return refusal(problem)

        rospy.Service("~" + name, service_class, serve)

    def _problem_of_distance(self, request):
        low, high = self._config.min_safety_distance_m, self._config.max_safety_distance_m
        if low <= request.goal <= high:
            return ""
        return "safety distance not set: %.2f m is outside of the allowed range [%.2f, %.2f] m" % (
            request.goal, low, high)

    def _serve_set_planner(self, request):
        if request.value in PLANNERS:
            return StringResponse(success=True, message="voxnav plans in the place of '%s'" % request.value)
        problem = "there is no planner '%s', only %s" % (request.value[:100], " and ".join(PLANNERS))
        self._note_refusal("set_planner: " + problem)
        return StringResponse(success=False, message=problem)

    def _note_refusal(self, problem):
        rospy.logwarn("[%s]: %s", NAME, problem)
        with self._lock:
            self._num_refused += 1
        self._diagnostics.set_counter("num_refused", self._num_refused)

    def _on_status(self, msg):
        self._status, self._heard = msg, RealTime.mark()

    def _publish(self):
        if self._heard is None or RealTime.elapsed_s(self._heard) > self._config.status_timeout_s:
            self._diagnostics.set_level(NodeDiagnostics.WARN, "the planning manager says nothing")
            return
        self._diagnostics.set_level(NodeDiagnostics.OK)
        status = self._status
        out = OctomapPlannerDiagnostics(header=status.header, idle=status.state == PlannerStatus.IDLE)
        out.header.stamp = rospy.Time.now()
        out.desired_reference = status.goal if status.has_goal else Point()
        out.best_goal = status.plan_end if status.has_plan else Point()
        self._published.publish(out)


def main():
    run_node(NAME, OctomapPlanner)
