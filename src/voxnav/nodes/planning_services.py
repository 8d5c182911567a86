# SPDX-License-Identifier: BSD-3-Clause
"""Services the planner calls, none of which may hang it, and MRS trajectories to and from the core."""

import queue
import threading

import numpy as np
import rospy
from mrs_msgs.msg import Path, Reference, TrajectoryReference
from mrs_msgs.srv import GetPathSrv, GetPathSrvRequest, TrajectoryReferenceSrv, TrajectoryReferenceSrvRequest
from std_srvs.srv import Trigger, TriggerRequest

import voxnav

# rospy offers no timeout on a call, so a call that hangs keeps its thread; more than this are not started.
MAX_HANGING_CALLS = 3
# MRS takes this step when a trajectory names none.
DEFAULT_DT_S = 0.2
# How often a call that has not been answered looks at the clock.
POLL_S = 0.05
# A start nearer than this is "now" to the MRS generator.
MIN_LEAD_S = 0.25


class ServiceError(RuntimeError):
    """The service is absent, did not answer in time, or failed; the text says which."""


class TimedService:
    """A service client whose calls end after a time, whatever the server does. Thread-safe."""

    def __init__(self, name, service_class, timeout_s, seam):
        """seam: of voxnav.nodes.time_seam; measures the time."""
        self._proxy, self._seam = rospy.ServiceProxy(name, service_class), seam
        self._timeout_s = timeout_s
        self._lock = threading.Lock()
        self._hanging = 0

    def call(self, request):
        """The response. Raises ServiceError."""
        with self._lock:
            if self._hanging >= MAX_HANGING_CALLS:
                raise ServiceError("%s hangs" % self._proxy.resolved_name)
            self._hanging += 1
        answer = queue.Queue()
        threading.Thread(target=self._run, args=(request, answer), daemon=True).start()
        response, error = self._wait_for(answer)
        if error is not None:
            raise ServiceError(str(error))
        return response

    def _wait_for(self, answer):
        begin = self._seam.mark()
        while True:
            try:
                return answer.get(timeout=POLL_S)
            except queue.Empty:
                if self._seam.elapsed_s(begin) > self._timeout_s or rospy.is_shutdown():
                    raise ServiceError("%s does not answer" % self._proxy.resolved_name)

    def _run(self, request, answer):
        try:
            answer.put((self._proxy(request), None))
        except (rospy.ServiceException, rospy.ROSException) as error:
            answer.put((None, error))
        finally:
            with self._lock:
                self._hanging -= 1


class ControlServices:
    """Trajectory generator and control manager. Methods return a problem as text, '' when there is none."""

    def __init__(self, config, deviation_m, seam):
        self._config, self._deviation_m = config, deviation_m
        timeout_s = config.service_timeout_s
        self._get_path = TimedService("~get_path_out", GetPathSrv, timeout_s + config.generator_time_s, seam)
        self._trajectory = TimedService("~trajectory_reference_out", TrajectoryReferenceSrv, timeout_s, seam)
        self._hover = TimedService("~hover_out", Trigger, timeout_s, seam)
        self._input_id = 0
        self._generated, self._headings = None, []  # newest answer of the generator, if it was asked for headings

    def generate(self, action, frame, now_s):
        """(problem, voxnav.Trajectory or None) through the waypoints of a generate action."""
        try:
            response = self._get_path.call(GetPathSrvRequest(path=self._path(action, frame, now_s)))
        except ServiceError as error:
            return str(error), None
        answered = response.trajectory
        if not response.success:
            return response.message or "refused without a reason", None
        if answered.header.frame_id not in ("", frame):
            return "answers in frame %s, not %s" % (answered.header.frame_id, frame), None
        points = np.array([(p.position.x, p.position.y, p.position.z) for p in answered.points]).reshape(-1, 3)
        self._generated = points if answered.use_heading and action.heading_rad is not None else None
        self._headings = [p.heading for p in answered.points]
        try:
            return "", voxnav.Trajectory(points, answered.dt if answered.dt > 1e-4 else DEFAULT_DT_S)
        except ValueError as error:
            return str(error), None

    def _path(self, action, frame, now_s):
        path = Path(fly_now=False, max_execution_time=self._config.generator_time_s,
                    max_deviation_from_path=self._deviation_m)
        path.header.frame_id = frame
        waypoints = action.waypoints_O
        if action.start_stamp_s is not None and action.start_stamp_s - now_s > MIN_LEAD_S:
            path.header.stamp = rospy.Time.from_sec(action.start_stamp_s)
        elif len(waypoints) > 1:
            waypoints = waypoints[1:]  # the generator begins with the present state itself
        path.points = [reference(p, action.heading_rad or 0.0) for p in waypoints]
        path.use_heading = action.heading_rad is not None
        # Otherwise the generator slows the flight down to turn to the heading 0 of every waypoint.
        path.relax_heading = not path.use_heading
        return path

    def publish(self, trajectory, frame):
        """Fly a voxnav.Trajectory at once; with the generator's headings, or, where it was cut, in the present one."""
        self._input_id += 1
        message = TrajectoryReference(input_id=self._input_id, fly_now=True, dt=trajectory.dt_s)
        message.header.frame_id = frame
        points = trajectory.points
        message.use_heading = self._generated is not None and np.array_equal(points, self._generated)
        headings = self._headings if message.use_heading else np.zeros(len(points))
        message.points = [reference(p, heading) for p, heading in zip(points, headings)]
        try:
            response = self._trajectory.call(TrajectoryReferenceSrvRequest(trajectory=message))
        except ServiceError as error:
            return str(error)
        if not response.success:
            return response.message or "refused without a reason"
        # The control manager accepts what its active tracker may still refuse.
        if response.tracker_successes and not response.tracker_successes[0]:
            return "tracker: " + (response.tracker_messages[0] if response.tracker_messages else "refused")
        return ""

    def hover(self):
        try:
            response = self._hover.call(TriggerRequest())
        except ServiceError as error:
            return str(error)
        return "" if response.success else (response.message or "hover refused")


def reference(point, heading_rad):
    out = Reference(heading=heading_rad)
    out.position.x, out.position.y, out.position.z = (float(x) for x in point)
    return out
