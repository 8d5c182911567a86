# SPDX-License-Identifier: BSD-3-Clause
"""Makes one pass over the messages of a recording, corrects their stamps, and yields them in order as records."""

from __future__ import annotations

from typing import Any, Iterator

import numpy as np

import voxnav
from voxnav import files as text_files
from voxnav.offline.datasets import Imu, Odometry, Scan
from voxnav.recordings.bag_files import BagFiles, RawMessage, frame_name
from voxnav.recordings.clocks import Stamped, TopicClock
from voxnav.recordings.left_out import LeftOut
from voxnav.recordings.lone_poses import ALONE, LonePoses, Posed
from voxnav.recordings.order import Ordered, TopicOrder
from voxnav.recordings.plan import RecordingPlan, sweep_s_of
from voxnav.recordings.problems import used_topics
from voxnav.recordings.survey import TopicSurvey
from voxnav.recordings.tf_poses import TfPoses


class BagStream:
    """The records of a recording. plan: a plan without error; left_out: counts messages that are not used."""

    def __init__(self, plan: RecordingPlan, files: BagFiles, left_out: LeftOut) -> None:
        assert plan.cloud is not None and plan.mount is not None
        self._plan, self._files, self._left_out = plan, files, left_out
        self._R_B_I = plan.mount.R_B_I
        used = used_topics(plan)
        self._topics: dict[str, TopicSurvey] = {topic.name: topic for _, topic in used}
        self._what = {topic.name: what for what, topic in used}
        clouds = [plan.cloud] + [sensor.topic for sensor in plan.further]
        self._sensors = {cloud.name: number for number, cloud in enumerate(clouds)}
        self._cameras = {name: camera for name, camera in plan.cameras.items() if name in self._sensors}
        # The pixels of an image are of one time.
        self._sweep_ns = {cloud.name: int(1e9 * sweep_s_of(cloud)) for cloud in clouds
                          if cloud.name not in self._cameras}
        self._infos = {camera.info_topic: camera for camera in self._cameras.values()}
        self._tf_poses = None if plan.tf_track is None else TfPoses(
            plan.survey, plan.tf_track, plan.options.max_pose_gap_s, left_out)
        self._clocks = {name: TopicClock(self._what[name], left_out, topic.period_s, topic.offsets_ns)
                        for name, topic in self._topics.items() if self._tf_poses is None or topic is not plan.odometry}
        self._order = TopicOrder(list(self._topics))
        self._lone_poses = LonePoses()

    def records(self) -> Iterator[Imu | Odometry | Scan]:
        """Yields all records that can be used. Messages are read once, and the memory for them is bounded."""
        self._files.left_out = self._left_out
        self._left_out.take(self._files.lost)
        going_on = dict(self._topics)
        for message in self._files.messages(list(self._topics) + list(self._infos)):
            for name in [name for name, topic in going_on.items() if topic.end_ns < message.record_ns]:
                del going_on[name]
                yield from self._end(name)
            yield from self._add(message)
        for name in going_on:
            yield from self._end(name)

    def notes(self) -> list[str]:
        """Returns sentences on clocks and the order of messages, for people."""
        clocks = list(self._clocks.values()) + list(self._tf_poses.clocks.values() if self._tf_poses else [])
        out = [note for clock in clocks for note in clock.notes]
        if self._order.num_forced:
            out.append("%d messages did not wait for those of other topics, which came too late" %
                       self._order.num_forced)
        return out

    def _add(self, message: RawMessage) -> Iterator[Imu | Odometry | Scan]:
        if message.topic in self._infos:
            self._take_info(message)
            return
        what, topic = self._what[message.topic], self._topics[message.topic]
        if self._tf_poses is not None and topic is self._plan.odometry:
            yield from self._order_tf(message.topic, self._tf_poses.add(message))
            return
        try:
            stamp_ns, frame = message.header()
            if frame != topic.frame:
                raise ValueError("its frame is '%s', that of the others '%s'" % (frame, topic.frame))
        except ValueError as error:
            self._left_out.add(what, str(error), message.record_ns)
            return
        for stamped in self._clocks[message.topic].add(stamp_ns, message.record_ns, message):
            yield from self._put_in_order(stamped)

    def _take_info(self, message: RawMessage) -> None:
        try:
            self._infos[message.topic].add_info(message.make())
        except ValueError as error:
            self._left_out.add("camera_info", str(error), message.record_ns)

    def _order_tf(self, name: str, poses: Iterator[Stamped]) -> Iterator[Imu | Odometry | Scan]:
        """Takes poses of the body with T_O_B (4, 4) as payload."""
        for stamped in poses:
            T = stamped.payload
            qx, qy, qz, qw = text_files.quaternion_from_rotation(T[:3, :3]).tolist()
            record = Odometry(stamped.stamp_ns, self._from_origin(T[:3, 3]), (qx, qy, qz, qw))
            pose = Posed(stamped.stamp_ns, T, stamped._replace(payload=record))
            yield from self._order_poses(name, self._lone_poses.add(pose))

    def _end(self, name: str) -> Iterator[Imu | Odometry | Scan]:
        if name in self._clocks:
            for stamped in self._clocks[name].end():
                yield from self._put_in_order(stamped)
        if self._topics[name] is self._plan.odometry:
            if self._tf_poses is not None:
                yield from self._order_tf(name, self._tf_poses.end())
            yield from self._order_poses(name, self._lone_poses.end())
        for ready in self._order.end(name):
            yield from self._record(ready)

    def _put_in_order(self, stamped: Stamped) -> Iterator[Imu | Odometry | Scan]:
        message: RawMessage = stamped.payload
        topic = self._topics[message.topic]
        if topic is self._plan.odometry:
            pose = self._pose(stamped)
            if pose is not None:
                yield from self._order_poses(message.topic, self._lone_poses.add(pose))
            return
        due_ns = stamped.stamp_ns + self._sweep_ns.get(message.topic, 0)
        for ready in self._order.add(message.topic, Ordered(due_ns, stamped.record_ns, len(message.data), stamped)):
            yield from self._record(ready)

    def _order_poses(self, name: str, poses: Iterator[tuple[Posed, float | None]]) -> Iterator[Imu | Odometry | Scan]:
        for pose, off_m in poses:
            stamped: Stamped = pose.payload
            if off_m is not None:
                self._left_out.add("odometry", ALONE, pose.stamp_ns)
                continue
            for ready in self._order.add(name, Ordered(pose.stamp_ns, stamped.record_ns, 0, stamped)):
                yield from self._record(ready)

    def _pose(self, stamped: Stamped) -> Posed | None:
        """Returns the pose of a message with its record as payload, or None if it is left out."""
        try:
            msg = stamped.payload.make()
            if self._plan.odometry is not None and frame_name(msg.child_frame_id) != self._plan.odometry.child:
                raise ValueError("its body is '%s', that of the others '%s'" % (
                    frame_name(msg.child_frame_id), self._plan.odometry.child))
            record = self._odometry(stamped.stamp_ns, msg)
            T = voxnav.pose_from_quaternion(record.position, record.q_xyzw)  # raises ValueError for invalid poses
        except ValueError as error:
            self._left_out.add("odometry", str(error), stamped.stamp_ns)
            return None
        return Posed(stamped.stamp_ns, T, stamped._replace(payload=record))

    def _odometry(self, stamp_ns: int, msg: Any) -> Odometry:
        p, q = msg.pose.pose.position, msg.pose.pose.orientation
        return Odometry(stamp_ns, self._from_origin((p.x, p.y, p.z)), (q.x, q.y, q.z, q.w))

    def _from_origin(self, position: Any) -> tuple[float, float, float]:
        """Returns a position (3,) of the recording in the frame of the map."""
        origin_m = np.zeros(3) if self._plan.origin_m is None else self._plan.origin_m
        x, y, z = (np.asarray(position) - origin_m).tolist()
        return x, y, z

    def _record(self, stamped: Stamped) -> Iterator[Imu | Odometry | Scan]:
        """Yields a message as a record; one that cannot be used is left out."""
        if isinstance(stamped.payload, Odometry):
            yield stamped.payload
            return
        message: RawMessage = stamped.payload
        what = self._what[message.topic]
        try:
            msg = message.make()
            sensor = self._sensors.get(message.topic)
            if message.topic in self._cameras:
                msg = self._cameras[message.topic].cloud(msg)
            yield (self._imu(stamped.stamp_ns, msg) if sensor is None
                   else Scan(stamped.stamp_ns, None, msg, None, sensor))
        except ValueError as error:
            self._left_out.add(what, str(error), stamped.stamp_ns)

    def _imu(self, stamp_ns: int, msg: Any) -> Imu:
        w, a = msg.angular_velocity, msg.linear_acceleration
        gyro, accel = np.array([w.x, w.y, w.z]), np.array([a.x, a.y, a.z])
        if not np.all(np.isfinite([gyro, accel])):
            raise ValueError("its values are not finite")
        if self._R_B_I is None or np.array_equal(self._R_B_I, np.eye(3)):
            return Imu(stamp_ns, gyro, accel)
        return Imu(stamp_ns, self._R_B_I @ gyro, self._R_B_I @ accel)
