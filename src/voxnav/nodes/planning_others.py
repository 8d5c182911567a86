# SPDX-License-Identifier: BSD-3-Clause
"""Other UAVs of the planner: hears where they will be, places that in the odometry frame, and passes it on."""

import functools
import threading

import numpy as np
import rospy
from geometry_msgs.msg import Point
from mrs_msgs.msg import FutureTrajectory
from visualization_msgs.msg import Marker, MarkerArray

import voxnav
from voxnav.fences import FenceError
from voxnav.msg import OtherUav, OtherUavs
from voxnav.nodes.planning_output import marker, points_of
from voxnav.nodes.time_seam import exact_time
from voxnav.other_uavs import Announced, AnnouncementError, Keeper, KeptTransform, OriginUnknown, begin_of

UTM, WORLD = "utm_origin", "world_origin"
YIELDING_COLOUR, LEADING_COLOUR, SILENT_COLOUR = (0.3, 0.9, 0.9, 0.8), (1.0, 0.3, 0.9, 0.9), (1.0, 0.5, 0.1, 0.9)
LINE_M = 0.15


def names_of(config):
    """Returns the names of all UAVs: those of the configuration, or of MRS's network_config."""
    names = config.robot_names or rospy.get_param(rospy.get_namespace() + "network/robot_names", [])
    if not isinstance(names, list) or not all(isinstance(name, str) and name for name in names):
        raise voxnav.ConfigError("network/robot_names must be a list of names, and is %r" % (names,))
    return names


class PlanningOthers:
    """Calls set_others(others, problem) ten times a second if there are other UAVs.

    config: voxnav.OtherUavsConfig; inputs: PlanningInputs; fences: PlanningFences, which finds frames; set_others takes
    a list of voxnav.OtherUav, None while they cannot be placed, which is a problem then
    """

    def __init__(self, config, inputs, uav_name, fences, set_others, seam):
        self._config, self._inputs, self._uav_name, self._fences = config, inputs, uav_name, fences
        self._set_others, self._seam = set_others, seam
        self._keeper = Keeper(config, uav_name, names_of(config))
        self._lock = threading.Lock()  # messages come in threads of their own
        self._utm, self._frame = KeptTransform(config.max_transform_age_s), ""
        self._silent, self._unheard, self._problem = [], [], ""
        self._counts = {"num_others_refused": 0, "num_others_other_clock": 0, "num_others_forgotten": 0}
        if not self._keeper.names:
            return
        rospy.loginfo("other UAVs: %s", ", ".join(self._keeper.names))
        self._output = rospy.Publisher("~others_out", OtherUavs, queue_size=2)
        self._markers = rospy.Publisher("~others_markers_out", MarkerArray, queue_size=2)
        for name in self._keeper.names:
            rospy.Subscriber("/%s/%s" % (name, config.topic), FutureTrajectory,
                             functools.partial(self._on_trajectory, name), queue_size=2)

    def counters(self):
        """Returns counters for the diagnostics, by name; none if there are no other UAVs."""
        if not self._keeper.names:
            return {}
        with self._lock:
            return dict(self._counts, num_others_silent=len(self._silent),
                        num_others_unheard=len(self._keeper.never_heard))

    @property
    def warning(self):
        """Names the UAVs that were configured and never heard; '' if there are none."""
        with self._lock:
            names = ", ".join(self._unheard)
        return "other UAVs that were never heard, and count as absent: " + names if names else ""

    def odometry_jumped(self):
        """Takes note that the odometry frame was moved, so that what tf told of it before is not so any more."""
        with self._lock:
            self._utm.forget(self._seam.now().to_sec())

    def _on_trajectory(self, name, msg):
        now_s = self._seam.now().to_sec()
        places = np.array([(p.x, p.y, p.z) for p in msg.points], dtype=np.float64).reshape(-1, 3)
        with self._lock:
            begin_s, is_our_clock = begin_of(msg.stamp.to_sec(), now_s, self._config.max_delay_s)
            self._counts["num_others_other_clock"] += 0 if is_our_clock else 1
            try:
                if msg.uav_name != name:
                    raise AnnouncementError("the trajectory on the topic of %s is of %r" % (name, msg.uav_name))
                self._keeper.take(Announced.of(name, msg.priority, begin_s, now_s, places))
            except AnnouncementError as error:
                self._counts["num_others_refused"] += 1
                rospy.logerr_throttle(1.0, "other UAVs: %s; its last one holds", error)
        if not is_our_clock:
            rospy.logwarn_throttle(10.0, "other UAVs: the clock of %s differs by %.2f s: its time of arrival counts",
                                   name, now_s - msg.stamp.to_sec())

    def update(self):
        """Passes on where the others are by now; to be called before each check of the flight."""
        if not self._keeper.names:
            return
        now = self._seam.now()
        with self._lock:
            self._tell_silent(now.to_sec())
            self._tell_unheard()
            problem, others = self._place(now.to_sec())
        if problem and problem != self._problem:
            rospy.logerr("other UAVs: %s", problem)
        self._problem = problem
        passed = None if problem else [self._passed(other, now.to_sec()) for other in others]
        self._set_others(passed, problem)
        self._publish(now, [] if problem else others, problem)

    def _tell_silent(self, now_s):
        silent = self._keeper.silent(now_s)
        for name in set(silent) - set(self._silent):
            rospy.logwarn("other UAVs: %s is silent, it is kept clear of where it may be", name)
        for name in self._keeper.forget(now_s):
            self._counts["num_others_forgotten"] += 1
            rospy.logwarn("other UAVs: %s is silent for %.0f s: from here on only the sensors tell where it is", name,
                          self._config.forget_after_s)
        self._silent = silent

    def _tell_unheard(self):
        unheard = self._keeper.never_heard
        for name in set(self._unheard) - set(unheard):
            rospy.loginfo("other UAVs: %s is heard", name)
        if set(unheard) - set(self._unheard):
            rospy.logwarn("other UAVs: not heard yet: %s", ", ".join(unheard))
        self._unheard = unheard

    def _place(self, now_s):
        """Returns (why the others cannot be placed or '', list of voxnav.other_uavs.Other)."""
        if self._config.must_be_heard and self._unheard:
            return "not heard yet: %s (others/must_be_heard)" % ", ".join(self._unheard), []
        if self._keeper.is_empty:
            return "", []
        if self._inputs.odometry_frame != self._frame:
            self._frame = self._inputs.odometry_frame
            self._utm.forget()
        told = ""
        try:
            self._utm.take(*self._find_utm())
        except FenceError as error:
            told = str(error)
        try:
            T_O_utm = self._utm.at(now_s)
        except OriginUnknown as error:
            return "where other UAVs are is not known: %s" % (told or error), []
        if told:
            rospy.logwarn_throttle(10.0, "other UAVs: %s; the last transform holds for %.1f s", told,
                                   self._config.max_transform_age_s)
        return "", self._keeper.others(now_s, T_O_utm)

    def _find_utm(self):
        """Returns T_O_utm, by tf or by the origin of the world configuration, and its stamp. Raises FenceError."""
        try:
            return self._fences.timed_T_O(UTM)
        except FenceError:
            origin = self._fences.world_origin
            if origin is None:
                raise
            T_world_utm = np.eye(4)
            T_world_utm[:2, 3] = (-origin.east_m, -origin.north_m)
            T_O_world, stamp_s = self._fences.timed_T_O(WORLD)
            return T_O_world.dot(T_world_utm), stamp_s

    def _passed(self, other, now_s):
        config = self._config
        return voxnav.OtherUav(name=other.name, stamp_s=other.begin_s, step_s=config.step_s, places=other.places_O,
                               radius_m=other.radius_m, growth_mps=config.growth_mps,
                               late_growth_mps=config.late_growth_mps, max_growth_m=config.max_growth_m,
                               horizon_s=other.horizon_s, seen_s=now_s)

    def _publish(self, now, others, problem):
        config = self._config
        out = OtherUavs()
        out.header.stamp, out.header.frame_id = now, self._inputs.odometry_frame
        for other in others:
            out.others.append(OtherUav(
                name=other.name, stamp=exact_time(other.begin_s), step_s=config.step_s,
                places=[Point(*(float(x) for x in place)) for place in other.places_O], radius_m=other.radius_m,
                growth_mps=config.growth_mps, late_growth_mps=config.late_growth_mps, max_growth_m=config.max_growth_m,
                horizon_s=other.horizon_s, body_radius_m=other.body_radius_m, gives_way=other.gives_way,
                silent_s=other.silent_s))
        out.unknown = [problem] if problem else []
        out.unknown += ["%s was never heard" % name for name in self._keeper.never_heard]
        out.unknown += ["%s is silent for too long" % name for name in self._keeper.forgotten]
        self._output.publish(out)
        if self._markers.get_num_connections() > 0:
            self._draw(now, others)

    def _draw(self, now, others):
        markers = [Marker(action=Marker.DELETEALL)]
        for other in others:
            colour = YIELDING_COLOUR if other.gives_way else LEADING_COLOUR
            colour = SILENT_COLOUR if other.body_radius_m == 0.0 else colour
            points = points_of(other.places_O)
            markers += [marker(self._inputs.odometry_frame, now, other.name + " way", Marker.LINE_STRIP, colour, LINE_M,
                               points),
                        marker(self._inputs.odometry_frame, now, other.name, Marker.SPHERE, colour[:3] + (0.25,),
                               2.0 * other.radius_m, points)]
        self._markers.publish(MarkerArray(markers=markers))
