# SPDX-License-Identifier: BSD-3-Clause
"""Subscribes to the inputs of the planner: vehicle, tracker, constraints, maps, map correction, heartbeats."""

import struct

import genpy
import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, Transform
from mrs_msgs.msg import ControlManagerDiagnostics, DynamicsConstraints, TrackerCommand, UavState
from nav_msgs.msg import Odometry

from voxnav import files
from voxnav.msg import SubmapPoses
from voxnav.nodes.planning_feeds import Heartbeats, LocalGridFeed, WaitingGridFeed
from voxnav.planning_manager.inputs import Control, TrackerState, problem_of_limits

IDENTITY = Transform(rotation=Quaternion(w=1.0))
TRACKER_STATES = frozenset(state.value for state in TrackerState)


def rotation(q):
    """Returns the 3x3 matrix of a geometry_msgs/Quaternion. Raises ValueError if it is not a rotation."""
    return files.rotation_from_quaternion([q.x, q.y, q.z, q.w])


def matrix(position, orientation):
    """Returns the (4, 4) matrix of the parts of a pose or a transform."""
    out = np.eye(4)
    out[:3, :3] = rotation(orientation)
    out[:3, 3] = (position.x, position.y, position.z)
    return out


def control_of(msg):
    """Returns the Control of an mrs_msgs/ControlManagerDiagnostics."""
    tracker = msg.tracker_status
    is_known = tracker.state in TRACKER_STATES
    return Control(msg.flying_normally, tracker.callbacks_enabled, tracker.tracking_trajectory, msg.bumper_active,
                   msg.joystick_active, msg.output_enabled, tracker.have_goal,
                   TrackerState(tracker.state) if is_known else TrackerState.INVALID, msg.active_tracker,
                   msg.active_controller)


class PlanningInputs:
    """Subscribes to all inputs and passes them to the manager and the map. `lock` protects the manager.

    seam: a time seam of voxnav.nodes.time_seam; on_jump(sentence) is called when the odometry frame jumps, and
    on_closed(sentence) when the map was closed, to which goals belong.
    """

    def __init__(self, config, manager, navigation_map, lock, on_jump, on_closed, seam):
        self._config, self._manager, self._map, self._lock = config, manager, navigation_map, lock
        self._on_jump, self._on_closed, self._seam = on_jump, on_closed, seam
        self._stamps_s = {"odometry": 0.0, "tracker": 0.0, "control": 0.0, "state": 0.0}  # newest stamps
        self._optimised = None  # T_W_O published by the optimiser, and the frame O; None: that of tf is used
        self._closed_at = None  # when the map before the present one was closed; None: the optimiser was not heard yet
        self._correction_stamp = self._correction_mark = None  # newest on tf, when first seen
        self.odometry_frame, self.map_frame = "", config.map_frame
        self._T_W_O, self._correction_frame = None, ""  # the map correction, and its frame O
        self.position_O = self.heading_O_rad = self.limits = None
        self.num_bad = 0
        self._iteration = None
        # Is told the poses of all submaps by their ids, T_W_O and its frame O with each solution of the graph.
        self.on_graph = lambda T_W_S, T_W_O, frame: None
        self._tracker_buffer = None
        self.tf_buffer = tf2_ros.Buffer(rospy.Duration(10.0))
        self._tf_listener = tf2_ros.TransformListener(self.tf_buffer)
        self._heartbeats = Heartbeats(config.required_nodes, config.heartbeat_timeout_s, seam)
        timeout_s = config.service_timeout_s
        seam.wait_for(self._is_caught_up)
        self.local = LocalGridFeed("~local_map_in", "~get_map_out", navigation_map, self._on_map, timeout_s, seam)
        self.obstacles = WaitingGridFeed("~obstacles_in", "~get_obstacles_out", navigation_map.apply_obstacles,
                                         lambda stamp_s: None, timeout_s, seam)
        rospy.Subscriber("~odometry_in", Odometry, self._on_odometry, queue_size=1)
        rospy.Subscriber("~uav_state_in", UavState, self._on_uav_state, queue_size=1)
        rospy.Subscriber("~control_diagnostics_in", ControlManagerDiagnostics, self._on_control, queue_size=1)
        rospy.Subscriber("~constraints_in", DynamicsConstraints, self._on_constraints, queue_size=1)
        self._poses_in = rospy.Subscriber("~submap_poses_in", SubmapPoses, self._on_submap_poses, queue_size=1)
        # The subscription is raw: decoding 40 full states at 100 Hz is costly, and the main rate suffices.
        rospy.Subscriber("~tracker_cmd_in", rospy.AnyMsg, self._on_tracker, queue_size=1)

    def _is_caught_up(self, now_s):
        """Returns True if all messages of the vehicle up to a time have come."""
        return min(self._stamps_s.values()) > now_s - 1e-4

    def _note(self, what, stamp_s):
        self._stamps_s[what] = stamp_s
        self._seam.arrived()

    def update(self, now_s):
        """Updates the inputs that have no messages of their own; to be called before each tick."""
        self._update_correction(now_s)
        self._update_prediction()
        with self._lock:
            self._manager.set_lost_nodes(self._heartbeats.lost())
            self._set_frames()

    def _set_frames(self):
        self._manager.set_frames(self.local.frame, self.odometry_frame, self._correction_frame)

    def reset(self):
        """Forgets stamps and corrections; to be called after a jump of the clock."""
        self.tf_buffer.clear()
        self._T_W_O = self._optimised = None
        self._map.clear_local()
        self._map.clear_obstacles()

    def _on_map(self, stamp_s):
        with self._lock:
            self._manager.set_map_stamp(stamp_s)
        self._seam.map_arrived(stamp_s)

    def _on_odometry(self, msg):
        p, v = msg.pose.pose.position, msg.twist.twist.linear
        try:
            R = rotation(msg.pose.pose.orientation)
        except ValueError:
            R = np.full((3, 3), np.nan)
        position, velocity = np.array([p.x, p.y, p.z]), R.dot((v.x, v.y, v.z))
        if not (np.isfinite(position).all() and np.isfinite(velocity).all()):
            self.num_bad += 1
            return
        self._map.set_vehicle(position)
        with self._lock:
            self.odometry_frame, self.position_O = msg.header.frame_id, position
            self.heading_O_rad = float(np.arctan2(R[1, 0], R[0, 0]))
            self._set_frames()  # before anything is checked with a place in another frame
            self._manager.set_vehicle(msg.header.stamp.to_sec(), position, velocity)
        self._note("odometry", msg.header.stamp.to_sec())

    def _on_uav_state(self, msg):
        if self._iteration is not None and msg.estimator_iteration != self._iteration:
            self._seam.deliver(0.0, self._on_jump, "odometry jumped: the estimator was switched or reset")
        self._iteration = msg.estimator_iteration
        self._note("state", msg.header.stamp.to_sec())

    def _on_control(self, msg):
        control = control_of(msg)
        with self._lock:
            self._manager.set_control(msg.stamp.to_sec(), control)
        self._note("control", msg.stamp.to_sec())

    def _on_constraints(self, msg):
        values = [msg.horizontal_speed, msg.horizontal_acceleration, msg.vertical_ascending_speed,
                  msg.vertical_ascending_acceleration, msg.vertical_descending_speed,
                  msg.vertical_descending_acceleration]
        problem = problem_of_limits(values)
        if problem:
            self.num_bad += 1
            rospy.logwarn_throttle(5.0, "%s: %s", problem, values)
        else:
            self.limits = values
        with self._lock:
            self._manager.set_limits(rospy.Time.now().to_sec(), values)  # the message has no stamp

    def _on_tracker(self, msg):
        self._tracker_buffer = msg._buff
        seconds, nanoseconds = struct.unpack_from("<II", msg._buff, 4)  # of the header, after its sequence
        self._note("tracker", seconds + 1e-9 * nanoseconds)

    def _update_prediction(self):
        buffer, self._tracker_buffer = self._tracker_buffer, None
        if buffer is None:
            return
        try:
            command = TrackerCommand().deserialize(buffer)
        except (genpy.DeserializationError, struct.error) as error:
            self.num_bad += 1
            rospy.logwarn_throttle(5.0, "tracker command cannot be decoded: %s", error)
            return
        prediction = command.full_state_prediction
        if not command.use_full_state_prediction or len(prediction.stamps) != len(prediction.position):
            return
        points = np.array([(p.x, p.y, p.z) for p in prediction.position]).reshape(-1, 3)
        if not np.isfinite(points).all():
            self.num_bad += 1
            return
        with self._lock:
            self._manager.set_prediction(command.header.stamp.to_sec(),
                                         np.array([s.to_sec() for s in prediction.stamps]), points,
                                         prediction.input_id)

    def _on_submap_poses(self, msg):
        if msg.header.frame_id:
            self.map_frame = msg.header.frame_id
        try:
            T_W_O = matrix(msg.T_W_O.position, msg.T_W_O.orientation)
            T_W_S = {number: matrix(pose.position, pose.orientation)
                     for number, pose in zip(msg.submap_ids, msg.T_W_S)}
        except ValueError as error:
            self._refuse_correction(error)
            return
        is_closed = self._closed_at is not None and msg.closed_at > self._closed_at
        self._closed_at = msg.closed_at
        closed = msg.closed_because if is_closed else ""
        self._seam.deliver(msg.header.stamp.to_sec(), self._take_optimised, T_W_S, T_W_O, msg.odometry_frame,
                           closed)

    def _take_optimised(self, T_W_S, T_W_O, frame, closed):
        if closed:
            self._map.clear_obstacles()
            self._on_closed(closed)
        self.on_graph(T_W_S, T_W_O, frame)
        self._optimised = (T_W_O, frame)

    def _update_correction(self, now_s):
        """Updates T_W_O, which the optimiser publishes with the poses of its submaps; tf shows that it is alive.

        Before there are submaps, and if nobody publishes their poses, T_W_O is that of tf.
        """
        frame = self.odometry_frame
        if not self._config.use_map_correction:
            self.map_frame = frame or self.map_frame
            self._set_correction(now_s, IDENTITY, frame)
            return
        if not frame:
            return
        try:
            found = self.tf_buffer.lookup_transform(self.map_frame, frame, rospy.Time(0))
        except tf2_ros.TransformException as error:
            rospy.logwarn_throttle(10.0, "no map correction: %s", error)
            return
        stamp = found.header.stamp
        if stamp != self._correction_stamp:
            self._correction_stamp, self._correction_mark = stamp, self._seam.mark()
        # A static transform has no stamp and holds for ever.
        age_s = 0.0 if stamp.is_zero() else self._seam.elapsed_s(self._correction_mark)
        self._set_correction(now_s - age_s, found.transform, frame)

    def _set_correction(self, stamp_s, transform, frame):
        if self._poses_in.get_num_connections() == 0:
            self._optimised = None  # a restarted optimiser will publish it again
        try:
            T = matrix(transform.translation, transform.rotation)
        except ValueError as error:
            self._refuse_correction(error)
            return
        # After the estimator was switched, tf knows T_W_O already, and the optimiser has still to follow.
        is_of_this_origin = self._optimised is not None and self._optimised[1] in ("", frame)
        self._keep_correction(stamp_s, self._optimised[0] if is_of_this_origin else T, frame)

    def _refuse_correction(self, error):
        self.num_bad += 1
        rospy.logwarn_throttle(5.0, "map correction refused: %s", error)

    def _keep_correction(self, stamp_s, T, frame):
        self._map.set_T_W_O(T)
        with self._lock:
            self._manager.set_T_W_O(stamp_s, T)
            self._T_W_O, self._correction_frame = T, frame
            self._set_frames()

    def T_O_of(self, frame, names):
        """Returns T_O_F (4, 4) of a frame by tf, which may have any of the names. Raises LookupError as tf says."""
        return self.timed_T_O_of(frame, names)[0]

    def timed_T_O_of(self, frame, names):
        """Returns T_O_F as T_O_of(), and the stamp in seconds at which tf told it; None for a static transform."""
        told = "it has no name"
        for name in names:
            try:
                found = self.tf_buffer.lookup_transform(self.odometry_frame, name, rospy.Time(0))
            except tf2_ros.TransformException as error:
                told = str(error).strip()
                continue
            stamp = found.header.stamp
            T_O_F = matrix(found.transform.translation, found.transform.rotation)
            return T_O_F, None if stamp.is_zero() else stamp.to_sec()
        raise LookupError("no transform from frame '%s' to %s: %s" % (frame, self.odometry_frame or "odometry", told))

    @property
    def T_W_O(self):
        """The map correction (4, 4); None while it is not known for the vehicle's frame."""
        return self._T_W_O if self._correction_frame == self.odometry_frame else None
