# SPDX-License-Identifier: BSD-3-Clause
"""The services of mrs_octomap_server: reset, save and load of maps by name, autosave, alignment of the altitude.

The maps themselves are those of local_mapper and submap_integrator, which publish them as OctoMaps, too.
"""

import os
import threading

import rospy
import tf2_ros
from mrs_msgs.msg import ControlManagerDiagnostics, Float64Stamped
from mrs_msgs.srv import String, StringRequest, StringResponse
from std_srvs.srv import Empty, EmptyResponse, Trigger, TriggerRequest

import voxnav
from voxnav.msg import NodeDiagnostics
from voxnav.nodes.node_base import Diagnostics, run_node
from voxnav.nodes.params import load_sections
from voxnav.nodes.planning_services import ServiceError, TimedService
from voxnav.nodes.time_seam import RealTime
from voxnav.octomap_face import MapNameError, ground_height_m, map_path, offset_m
from voxnav.octomap_face.map_names import known_names, replace_with_backup, unfinished_path

NAME = "octomap_server"
RETRY_S = 1.0


class NotYet(RuntimeError):
    """Something that the altitude of a map needs has not come yet, or not lately; the text says what."""


class Refused(RuntimeError):
    """The request cannot be fulfilled; the text says why."""


class Fresh:
    """The newest message of a topic, as long as it is not older than a time."""

    def __init__(self, topic, message_class, timeout_s):
        self._timeout_s, self._message, self._mark = timeout_s, None, None
        self._subscriber = rospy.Subscriber(topic, message_class, self._on_message, queue_size=1)

    def _on_message(self, msg):
        self._message, self._mark = msg, RealTime.mark()

    def get(self):
        """Returns the message, or None."""
        if self._mark is None or RealTime.elapsed_s(self._mark) > self._timeout_s:
            return None
        return self._message


class OctomapServer:
    def __init__(self):
        self._config, = load_sections(node=voxnav.OctomapServerConfig)
        self._diagnostics = Diagnostics(NAME)
        seam, timeout_s = RealTime(), self._config.service_timeout_s
        self._save_map = TimedService("~save_out", String, timeout_s, seam)
        self._load_map = TimedService("~load_out", String, timeout_s, seam)
        self._reset_local = TimedService("~reset_local_out", Trigger, timeout_s, seam)
        self._reset_global = TimedService("~reset_global_out", Trigger, timeout_s, seam)
        self._control = Fresh("~control_diagnostics_in", ControlManagerDiagnostics, self._config.input_timeout_s)
        self._height = Fresh("~height_in", Float64Stamped, self._config.input_timeout_s)
        self._tf_buffer = tf2_ros.Buffer()
        self._tf_listener = tf2_ros.TransformListener(self._tf_buffer)
        self._lock = threading.Lock()  # one map is saved or loaded at a time
        self._num_saved = self._num_failed = 0
        rospy.Service("~reset_map", Empty, self._serve_reset)
        rospy.Service("~save_map", String, self._serve_save)
        rospy.Service("~load_map", String, self._serve_load)
        self._is_loading_at_start = self._config.loads_at_start
        if self._is_loading_at_start:
            seam.every(1.0 / RETRY_S, self._load_at_start)
        if self._config.autosave_period_s > 0.0:
            seam.every(1.0 / self._config.autosave_period_s, self._autosave)

    # Services

    def _serve_reset(self, _):
        problem = self._reset()
        self._tell(problem)
        # An empty answer cannot say that something failed: the call itself has to.
        return None if problem else EmptyResponse()

    def _serve_save(self, request):
        return self._answer(lambda: self._save(request.value))

    def _serve_load(self, request):
        return self._answer(lambda: self._load(request.value))

    def _answer(self, work):
        try:
            said = work()
            self._tell("")
            return StringResponse(success=True, message=said)
        except (MapNameError, NotYet, Refused, ServiceError, OSError, RuntimeError) as error:
            self._tell(str(error))
            return StringResponse(success=False, message=str(error))

    def _tell(self, problem):
        self._num_failed += bool(problem)
        if problem:
            rospy.logerr("[%s]: %s", NAME, problem)
        self._diagnostics.set_counter("num_failed", self._num_failed)
        self._diagnostics.set_counter("num_saved", self._num_saved)
        self._diagnostics.set_level(NodeDiagnostics.ERROR if problem else NodeDiagnostics.OK, problem)

    # Work

    def _reset(self):
        """Clears the local map, then the global one. Returns a problem, or ''."""
        for service in (self._reset_local, self._reset_global):
            try:
                response = service.call(TriggerRequest())
            except ServiceError as error:
                return "the map is not cleared: %s" % error
            if not response.success:
                return "the map is not cleared: %s" % response.message
        return ""

    def _save(self, name):
        path = map_path(self._config.map_path, name)
        with self._lock:
            os.makedirs(os.path.dirname(path), exist_ok=True)
            unfinished = unfinished_path(path)
            said = _said(self._save_map.call(StringRequest(value=unfinished)))
            replace_with_backup(unfinished, path)
        self._num_saved += 1
        return said.replace(unfinished, path)

    def _load(self, name):
        path = map_path(self._config.map_path, name)
        if not os.path.exists(path):
            names = known_names(self._config.map_path)[:20]
            raise Refused("there is no map '%s' in %s; there is %s" % (
                name, self._config.map_path, ", ".join(names) or "none"))
        with self._lock:
            rise_m = self._rise_m(path) if self._config.aligns_altitude else 0.0
            asked = "%s 0 0 %.3f 0" % (path, rise_m) if rise_m else path
            said = _said(self._load_map.call(StringRequest(value=asked)))
        return said + (", raised by %.2f m" % rise_m if self._config.aligns_altitude else "")

    def _rise_m(self, path):
        """Returns by how much the map must rise so that its ground lies below the vehicle. Raises NotYet or Refused."""
        control = self._control.get()
        if control is None:
            raise NotYet("no diagnostics of the control manager: it is not known whether the vehicle stands")
        height_m = None
        if control.output_enabled:
            if self._height.get() is None:
                raise Refused("the altitude of a map cannot be aligned in the air without a measured height")
            height_m = self._height.get().value
        position = self._position_W()
        ground_m = ground_height_m(path, position, self._config.ground_distance_m)
        if ground_m is None:
            raise Refused("the map knows no ground within %.1f m of the vehicle at (%.1f, %.1f), so its altitude "
                          "cannot be aligned" % (self._config.ground_distance_m, position[0], position[1]))
        return offset_m(ground_m, position[2], height_m, self._config.robot_height_m)

    def _position_W(self):
        try:
            found = self._tf_buffer.lookup_transform(self._config.map_frame, self._config.body_frame, rospy.Time(0))
        except tf2_ros.TransformException as error:
            raise NotYet("the place of the vehicle is not known: %s" % error)
        p = found.transform.translation
        return (p.x, p.y, p.z)

    # Timers

    def _load_at_start(self):
        if not self._is_loading_at_start:
            return
        try:
            rospy.loginfo("[%s]: %s", NAME, self._load(self._config.map_name))
            self._is_loading_at_start = False
            self._tell("")
        except (NotYet, ServiceError) as error:
            self._diagnostics.set_level(NodeDiagnostics.WARN, "map '%s' is not loaded yet: %s" % (
                self._config.map_name, error))
        except (Refused, MapNameError, OSError, RuntimeError) as error:
            self._is_loading_at_start = False
            self._tell("map '%s' is not loaded: %s" % (self._config.map_name, error))

    def _autosave(self):
        control = self._control.get()
        if self._is_loading_at_start or control is None or not control.flying_normally:
            return
        response = self._serve_save(StringRequest(value=self._config.map_name))
        if not response.success:
            rospy.logerr_throttle(10.0, "[%s]: autosave: %s", NAME, response.message)


def _said(response):
    """Returns what a service says. Raises Refused if it refuses."""
    if not response.success:
        raise Refused(response.message)
    return response.message


def main():
    run_node(NAME, OctomapServer)
