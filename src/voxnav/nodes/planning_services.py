# SPDX-License-Identifier: BSD-3-Clause
"""The services that the planner calls without ever hanging on them, and conversions of MRS trajectories."""

import queue
import threading

import numpy as np
import rospy
from mrs_msgs.msg import Path, Reference, TrajectoryReference
from mrs_msgs.srv import GetPathSrv, GetPathSrvRequest, TrajectoryReferenceSrv, TrajectoryReferenceSrvRequest
from std_srvs.srv import Trigger, TriggerRequest

import voxnav
from voxnav.nodes.time_seam import exact_time
from voxnav.planning_manager import Generated, Means
from voxnav.planning_manager.input_ids import FIRST_ID, after

# rospy offers no timeout for calls, so a call that hangs keeps its thread. No more threads than this are started.
MAX_HANGING_CALLS = 3
# MRS uses this time step if a trajectory does not tell its own.
DEFAULT_DT_S = 0.2
# Period at which an unanswered call checks its timeout.
POLL_S = 0.05
# The MRS generator takes a start within this time for "now".
MIN_LEAD_S = 0.25


class ServiceError(RuntimeError):
    """The service is absent, did not answer in time, or failed; the text says which."""


class TimedService:
    """A service client whose calls end after a time, whatever the server does. Thread-safe."""

    def __init__(self, name, service_class, timeout_s, seam):
        """Makes a client. seam: the time seam of voxnav.nodes.time_seam, by which timeouts are measured."""
        self._proxy, self._seam = rospy.ServiceProxy(name, service_class), seam
        self._timeout_s = timeout_s
        self._lock = threading.Lock()
        self._hanging = 0

    def call(self, request):
        """Calls the service and returns its response. Raises ServiceError."""
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
    """Trajectory generator and control manager. Methods return a problem as text, '' if there is none."""

    def __init__(self, config, deviation_m, headings, seam):
        self._config, self._deviation_m, self._headings_of = config, deviation_m, headings
        timeout_s = config.service_timeout_s
        self._get_path = TimedService("~get_path_out", GetPathSrv, timeout_s + config.generator_time_s, seam)
        self._trajectory = TimedService("~trajectory_reference_out", TrajectoryReferenceSrv, timeout_s, seam)
        self._hover = TimedService("~hover_out", Trigger, config.hover_timeout_s, seam)
        self._ehover = TimedService("~ehover_out", Trigger, config.hover_timeout_s, seam)
        # A trajectory to rest must not wait behind another one, nor as long.
        self._rest = TimedService("~trajectory_reference_out", TrajectoryReferenceSrv, config.hover_timeout_s, seam)
        self._input_id = FIRST_ID
        self._generated, self._headings = None, []  # last answer of the generator, if headings were requested

    def generate(self, action, frame, heading_rad, now_s):
        """Generates a trajectory through the waypoints of an action. Returns Generated, or a problem as text.

        heading_rad: present heading of the vehicle, or None if it is not known
        """
        path = self._path(action, frame, heading_rad, now_s)
        try:
            response = self._get_path.call(GetPathSrvRequest(path=path))
        except ServiceError as error:
            return str(error)
        answered = response.trajectory
        if not response.success:
            return response.message or "refused without a reason"
        if answered.header.frame_id not in ("", frame):
            return "answers in frame %s, not %s" % (answered.header.frame_id, frame)
        points = np.array([(p.position.x, p.position.y, p.position.z) for p in answered.points]).reshape(-1, 3)
        self._generated = points if answered.use_heading and path.use_heading else None
        self._headings = [p.heading for p in answered.points]
        try:
            trajectory = voxnav.Trajectory(points, answered.dt if answered.dt > 1e-4 else DEFAULT_DT_S)
        except ValueError as error:
            return str(error)
        stamp = answered.header.stamp
        return Generated(trajectory, None if stamp.is_zero() else stamp.to_sec())

    def _path(self, action, frame, heading_rad, now_s):
        path = Path(fly_now=False, max_execution_time=self._config.generator_time_s,
                    max_deviation_from_path=self._deviation_m)
        path.header.frame_id = frame
        points, headings = self._headings_of.apply(path, action.waypoints_O, action.heading_rad, heading_rad)
        if action.start_stamp_s is not None and action.start_stamp_s - now_s > MIN_LEAD_S:
            path.header.stamp = rospy.Time.from_sec(action.start_stamp_s)
        elif len(points) > 1:
            points, headings = points[1:], headings[1:]  # the generator begins with the present state itself
        path.points = [reference(p, heading) for p, heading in zip(points, headings)]
        return path

    def publish(self, trajectory, stamp_s, frame):
        """Publishes a voxnav.Trajectory to be flown at once; if it was cut, in the present heading.

        stamp_s: time of its first point, so that the tracker skips what is over by now; None: the present time
        Returns the problem, and whether the control manager flies another trajectory than this one.
        """
        return self._fly(self._trajectory, trajectory, stamp_s, frame)

    def stop(self, action, frame):
        """Stops the vehicle by the means of a Hover."""
        if action.trajectory is not None:
            problem, is_modified = self._fly(self._rest, action.trajectory, None, frame)
            return problem or ("cut at the safety area of the control manager" if is_modified else "")
        service = self._ehover if action.means is Means.EHOVER else self._hover
        try:
            response = service.call(TriggerRequest())
        except ServiceError as error:
            return str(error)
        return "" if response.success else (response.message or "refused without a reason")

    def _fly(self, service, trajectory, stamp_s, frame):
        self._input_id = after(self._input_id)
        message = TrajectoryReference(input_id=self._input_id, fly_now=True, dt=trajectory.dt_s)
        message.header.frame_id = frame
        if stamp_s is not None:
            message.header.stamp = exact_time(stamp_s)
        points = trajectory.points
        message.use_heading = self._generated is not None and np.array_equal(points, self._generated)
        headings = self._headings if message.use_heading else np.zeros(len(points))
        message.points = [reference(p, heading) for p, heading in zip(points, headings)]
        try:
            response = service.call(TrajectoryReferenceSrvRequest(trajectory=message))
        except ServiceError as error:
            return str(error), False
        if not response.success:
            return response.message or "refused without a reason", False
        # The control manager may accept a trajectory that its active tracker then refuses.
        if response.tracker_successes and not response.tracker_successes[0]:
            return "tracker: " + (response.tracker_messages[0] if response.tracker_messages else "refused"), False
        return "", response.modified


def reference(point, heading_rad):
    out = Reference(heading=heading_rad)
    out.position.x, out.position.y, out.position.z = (float(x) for x in point)
    return out
