# SPDX-License-Identifier: BSD-3-Clause
"""What the planner is told: vehicle, tracker, constraints, maps, map correction, heartbeats."""

import collections
import struct
import threading
import time

import genpy
import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, Transform
from mrs_msgs.msg import ControlManagerDiagnostics, DynamicsConstraints, TrackerCommand, UavState
from nav_msgs.msg import Odometry

import voxnav
from voxnav import files
from voxnav.msg import GridUpdate, NodeDiagnostics, SubmapPoses
from voxnav.nodes.planning_services import ServiceError, TimedService
from voxnav.srv import GetGrid, GetGridRequest

SNAPSHOT_INTERVAL_S = 1.0
# In lock-step time waits for the planner, so that what it waits for comes at once or never.
INPUT_WAIT_S = 0.5
IDENTITY = Transform(rotation=Quaternion(w=1.0))


def rotation(q):
    """3x3 matrix of a geometry_msgs/Quaternion. Raises ValueError when it is none."""
    return files.rotation_from_quaternion([q.x, q.y, q.z, q.w])


def matrix(position, orientation):
    """(4, 4) of the parts of a pose or a transform."""
    out = np.eye(4)
    out[:3, :3] = rotation(orientation)
    out[:3, 3] = (position.x, position.y, position.z)
    return out


class GridFeed:
    """One GridUpdate topic into a layer of the NavigationMap; asks for a snapshot when a change was missed."""

    def __init__(self, topic, service, apply, on_applied, timeout_s, is_deferred=False):
        """is_deferred: updates wait for release()."""
        self._apply, self._on_applied = apply, on_applied
        self._deferred = collections.deque(maxlen=100) if is_deferred else None
        self._service = TimedService(service, GetGrid, timeout_s)
        self._recent = collections.deque(maxlen=30)  # changes that come while the snapshot is on its way
        self._lock = threading.Lock()
        self._is_fetching, self._fetched = False, -1e18
        self.num_snapshots = self.num_refused = 0
        self.frame = ""
        rospy.Subscriber(topic, GridUpdate, self._on_update, queue_size=20, buff_size=1 << 22)

    def _on_update(self, msg):
        if self._deferred is None:
            self._receive(msg)
        else:
            with self._lock:
                self._deferred.append(msg)

    def release(self, before_s):
        """Take what was stamped before a time and has been deferred."""
        with self._lock:
            ready = [msg for msg in self._deferred if msg.header.stamp.to_sec() < before_s]
            for msg in ready:
                self._deferred.remove(msg)
        for msg in ready:
            self._receive(msg)

    def _receive(self, msg):
        with self._lock:
            self._recent.append(msg)
            needs_snapshot = self._take(msg) == voxnav.Applied.NEEDS_SNAPSHOT
            if not needs_snapshot or self._is_fetching or time.monotonic() < self._fetched + SNAPSHOT_INTERVAL_S:
                return
            self._is_fetching = True
        threading.Thread(target=self._fetch, daemon=True).start()

    def _take(self, msg):
        try:
            result = self._apply(sequence=msg.sequence, resolution_m=msg.resolution_m,
                                 block_indices=np.array(msg.block_indices, dtype=np.int32), states=msg.states,
                                 removed=np.array(msg.removed_block_indices, dtype=np.int32),
                                 is_snapshot=msg.is_snapshot)
        except ValueError as error:
            self.num_refused += 1
            rospy.logerr_throttle(1.0, "grid update refused: %s", error)
            return voxnav.Applied.NEEDS_SNAPSHOT
        if result == voxnav.Applied.APPLIED:
            self.frame = msg.header.frame_id
            self._on_applied(msg.header.stamp.to_sec())
        return result

    def _fetch(self):
        try:
            response = self._service.call(GetGridRequest())
        except ServiceError as error:
            response = None
            rospy.logwarn_throttle(5.0, "no snapshot: %s", error)
        with self._lock:
            self._is_fetching, self._fetched = False, time.monotonic()
            if response is None or not response.success:
                return
            self.num_snapshots += 1
            response.grid.is_snapshot = True
            self._take(response.grid)
            for msg in self._recent:
                if msg.sequence > response.grid.sequence:
                    self._take(msg)


class Heartbeats:
    """Which of the required nodes are gone (nobody publishes their diagnostics) or silent, in wall time."""

    def __init__(self, names, timeout_s):
        self._timeout_s = timeout_s
        self._heard = {name: -1e18 for name in names}
        self._topics = {name: rospy.Subscriber(name + "/diagnostics", NodeDiagnostics, self._on_message,
                                               callback_args=name, queue_size=2) for name in names}

    def _on_message(self, _, name):
        self._heard[name] = time.monotonic()

    def lost(self):
        for name, topic in self._topics.items():
            if topic.get_num_connections() == 0:
                self._heard[name] = -1e18  # once back, it has to say so
        limit = time.monotonic() - self._timeout_s
        return [name for name, heard in self._heard.items() if heard < limit]


class PlanningInputs:
    """Subscribes to everything and keeps manager and map up to date. `lock` guards the manager.

    on_cycle(stamp_s) is called for every local map in lock-step; None otherwise.
    """

    def __init__(self, config, manager, navigation_map, lock, on_jump, on_cycle=None):
        self._config, self._manager, self._map, self._lock = config, manager, navigation_map, lock
        self._on_jump, self._on_cycle = on_jump, on_cycle
        self._corrections = collections.deque(maxlen=100)  # of lock-step: (stamp_s, T_W_O)
        self._arrived = threading.Condition()
        self._odometry_s = self._tracker_s = self._control_s = 0.0
        self.odometry_frame, self.map_frame = "", config.map_frame
        self.T_W_O = None
        self.position_O = self.limits = None
        self.num_bad = 0
        self._iteration = None
        self._tracker_buffer = None
        self.tf_buffer = tf2_ros.Buffer(rospy.Duration(10.0))
        self._tf_listener = tf2_ros.TransformListener(self.tf_buffer)
        self._heartbeats = Heartbeats(config.required_nodes, config.heartbeat_timeout_s)
        timeout_s = config.service_timeout_s
        self.local = GridFeed("~local_map_in", "~get_map_out", navigation_map.apply_local, self._on_map, timeout_s)
        self.obstacles = GridFeed("~obstacles_in", "~get_obstacles_out", navigation_map.apply_obstacles,
                                  lambda stamp_s: None, timeout_s, is_deferred=on_cycle is not None)
        rospy.Subscriber("~odometry_in", Odometry, self._on_odometry, queue_size=1)
        rospy.Subscriber("~uav_state_in", UavState, self._on_uav_state, queue_size=1)
        rospy.Subscriber("~control_diagnostics_in", ControlManagerDiagnostics, self._on_control, queue_size=1)
        rospy.Subscriber("~constraints_in", DynamicsConstraints, self._on_constraints, queue_size=1)
        rospy.Subscriber("~submap_poses_in", SubmapPoses, self._on_submap_poses, queue_size=1)
        # Raw: a prediction of 40 full states at 100 Hz costs much to decode and is needed at the main rate at most.
        rospy.Subscriber("~tracker_cmd_in", rospy.AnyMsg, self._on_tracker, queue_size=1)

    def catch_up(self, map_stamp_s, now_s):
        """Lock-step: what of the vehicle is known at the instant of a cycle, what of the global map was before it."""
        with self._arrived:
            self._arrived.wait_for(lambda: min(self._odometry_s, self._tracker_s, self._control_s) > now_s - 1e-4,
                                   INPUT_WAIT_S)
        self.obstacles.release(map_stamp_s)
        while self._corrections and self._corrections[0][0] < map_stamp_s:
            self.T_W_O = self._corrections.popleft()[1]
        T = np.eye(4) if self.T_W_O is None else self.T_W_O
        self._keep_correction(now_s, T)

    def update(self, now_s):
        """Before each tick: what is not driven by its own message."""
        if self._on_cycle is None:
            self._update_correction(now_s)
        self._update_prediction()
        with self._lock:
            self._manager.set_lost_nodes(self._heartbeats.lost())
            self._manager.set_frames(self.local.frame, self.odometry_frame)

    def reset(self):
        """After a jump of the clock."""
        self.tf_buffer.clear()
        self.T_W_O = None
        self._map.clear_local()
        self._map.clear_obstacles()

    def _on_map(self, stamp_s):
        with self._lock:
            self._manager.set_map_stamp(stamp_s)
        if self._on_cycle is not None:
            self._on_cycle(stamp_s)

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
        self.odometry_frame = msg.header.frame_id
        self.position_O = position
        self._map.set_vehicle(position)
        with self._lock:
            self._manager.set_vehicle(msg.header.stamp.to_sec(), position, velocity)
        with self._arrived:
            self._odometry_s = msg.header.stamp.to_sec()
            self._arrived.notify_all()

    def _on_uav_state(self, msg):
        if self._iteration is not None and msg.estimator_iteration != self._iteration:
            self._on_jump("odometry jumped: the estimator was switched or reset")
        self._iteration = msg.estimator_iteration

    def _on_control(self, msg):
        with self._lock:
            self._manager.set_control(msg.stamp.to_sec(), msg.flying_normally, msg.tracker_status.callbacks_enabled,
                                      msg.tracker_status.tracking_trajectory)
        with self._arrived:
            self._control_s = msg.stamp.to_sec()
            self._arrived.notify_all()

    def _on_constraints(self, msg):
        values = [msg.horizontal_speed, msg.horizontal_acceleration, msg.vertical_ascending_speed,
                  msg.vertical_ascending_acceleration, msg.vertical_descending_speed,
                  msg.vertical_descending_acceleration]
        if not np.isfinite(values).all() or min(values) <= 0.0:
            self.num_bad += 1
            return
        self.limits = values
        with self._lock:
            self._manager.set_limits(rospy.Time.now().to_sec(), values)  # the message has no stamp

    def _on_tracker(self, msg):
        self._tracker_buffer = msg._buff
        if self._on_cycle is not None:
            seconds, nanoseconds = struct.unpack_from("<II", msg._buff, 4)  # of the header, after its sequence
            with self._arrived:
                self._tracker_s = seconds + 1e-9 * nanoseconds
                self._arrived.notify_all()

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
                                         np.array([s.to_sec() for s in prediction.stamps]), points)

    def _on_submap_poses(self, msg):
        if msg.header.frame_id:
            self.map_frame = msg.header.frame_id
        if self._on_cycle is not None:
            self._corrections.append((msg.header.stamp.to_sec(), matrix(msg.T_W_O.position, msg.T_W_O.orientation)))

    def _update_correction(self, now_s):
        if not self._config.use_map_correction:
            self.map_frame = self.odometry_frame or self.map_frame
            self._set_correction(now_s, IDENTITY)
            return
        if not self.odometry_frame:
            return
        try:
            found = self.tf_buffer.lookup_transform(self.map_frame, self.odometry_frame, rospy.Time(0))
        except tf2_ros.TransformException as error:
            rospy.logwarn_throttle(10.0, "no map correction: %s", error)
            return
        # A static transform has no stamp and holds for ever.
        self._set_correction(found.header.stamp.to_sec() or now_s, found.transform)

    def _set_correction(self, stamp_s, transform):
        try:
            self._keep_correction(stamp_s, matrix(transform.translation, transform.rotation))
        except ValueError as error:
            self.num_bad += 1
            rospy.logwarn_throttle(5.0, "map correction refused: %s", error)

    def _keep_correction(self, stamp_s, T):
        self._map.set_T_W_O(T)
        with self._lock:
            self._manager.set_T_W_O(stamp_s, T)
        self.T_W_O = T
