# SPDX-License-Identifier: BSD-3-Clause
"""Surveys a recording within seconds: all of a small one, and windows of a large one."""

from __future__ import annotations

from collections import Counter
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.recordings import cloud_samples
from voxnav.recordings.bag_files import TF_TOPICS, BagFiles, RawMessage, Topic, frame_name
from voxnav.recordings.clocks import clock_offsets_ns
from voxnav.recordings.depth_images import DepthImages
from voxnav.recordings.frames import FrameGraph
from voxnav.recordings.left_out import LeftOut
from voxnav.recordings.lone_poses import ALONE, LonePoses, Posed

CLOUD, ODOMETRY, IMU = "sensor_msgs/PointCloud2", "nav_msgs/Odometry", "sensor_msgs/Imu"
KINDS = (CLOUD, ODOMETRY, IMU)

# Larger recordings are read in windows: at their beginning, at their end, and some in between.
_WHOLE_BYTES = 300 * 1024 * 1024
_BEGIN_S, _WINDOW_S, _NUM_WINDOWS = 3.0, 1.0, 10
_MAX_TF_MESSAGES = 20_000
# The number of clouds of each topic that are read; the windows of a large recording give no more.
_NUM_CLOUDS = 16
MAX_POSES = 5_000
_MAX_FAULTS = 10
_MIN_GAP_S = 0.3  # a shorter time between messages is no gap, even if it is several of their periods


class Gap(NamedTuple):
    """A pause of a topic, by its record times in seconds."""

    at_s: float
    length_s: float


class TopicSurvey:
    """Figures of the messages of one topic. Times are record times unless stated otherwise; all lists are bounded."""

    def __init__(self, topic: Topic, record_ns: Array) -> None:
        self.topic = topic
        self.begin_ns, self.end_ns = int(record_ns[0]), int(record_ns[-1])
        steps_s = 1e-9 * np.diff(record_ns)
        self.period_s = float(np.median(steps_s)) if len(steps_s) else None
        self.gaps = [Gap(1e-9 * float(record_ns[i]), float(steps_s[i]))
                     for i in np.flatnonzero(steps_s > max(_MIN_GAP_S, 5.0 * (self.period_s or 0.0)))[:100]]
        self.frames: Counter[str] = Counter()
        self.children: Counter[str] = Counter()  # child frames of odometry
        self.stamps_ns: List[int] = []  # stamps of the messages that were read
        self.records_ns: List[int] = []
        self.poses: List[Any] = []  # positions (3,) of odometry
        self.lone_poses = LonePoses()
        self.faults: Counter[str] = Counter()  # why messages that were read are of no use, with their numbers
        self.forces: List[Any] = []  # accelerations (3,) of an IMU, from the beginning
        self.clouds: List[cloud_samples.CloudSample] = []
        self.times = voxnav.PointTimes()  # judges the point times of the clouds that were read

    @property
    def name(self) -> str:
        return self.topic.name

    @property
    def rate_hz(self) -> float | None:
        return 1.0 / self.period_s if self.period_s else None

    @property
    def frame(self) -> str:
        """Returns the most frequent frame id, without a leading slash; it is empty if the messages name none."""
        return self.frames.most_common(1)[0][0] if self.frames else ""

    @property
    def child(self) -> str:
        return self.children.most_common(1)[0][0] if self.children else ""

    @property
    def offsets_ns(self) -> list[int]:
        """Returns the result of clock_offsets_ns() for this topic."""
        return clock_offsets_ns(np.array(self.stamps_ns, dtype=np.int64), np.array(self.records_ns, dtype=np.int64))

    @property
    def offset_ns(self) -> int | None:
        """Returns the offset of the usual clock, or None if record times do not show it."""
        return self.offsets_ns[0] if self.offsets_ns else None

    @property
    def stamp_period_s(self) -> float | None:
        """Returns the time between stamps of consecutive messages. Record times come in bursts and do not show it."""
        steps = np.diff(np.array(self.stamps_ns, dtype=np.int64)) * 1e-9
        steps = steps[steps > 0]
        return float(np.median(steps)) if len(steps) else self.period_s


class Survey:
    """The topics of clouds, odometry and IMU by name, and the frames. left_out: counts of what could not be read.

    cameras: those whose depth images are looked at as well, by topic.
    """

    def __init__(self, files: BagFiles, cameras: Mapping[str, DepthImages]) -> None:
        self.files, self._cameras = files, cameras
        for camera in cameras.values():
            camera.take_first_info(files)
        self.left_out = LeftOut()
        self.frames = FrameGraph()
        self.all_topics: Dict[str, Topic] = files.topics()
        self.topics: Dict[str, TopicSurvey] = {}
        for name, topic in sorted(self.all_topics.items()):
            if topic.kind not in KINDS and name not in cameras:
                continue
            record_ns = files.record_times_ns(name)
            if len(record_ns):
                self.topics[name] = TopicSurvey(topic, record_ns)
        self.is_whole = files.size_bytes <= _WHOLE_BYTES
        self._look_at_frames(all_of_tf=self.is_whole)
        for message in self._sample():
            self._look_at(message)

    def of_kind(self, kind: str) -> list[TopicSurvey]:
        return [topic for topic in self.topics.values() if topic.topic.kind == kind]

    def tf_windows(self, name: str) -> list[tuple[int | None, int | None]]:
        """Returns the times (from, until) in ns within which messages of a topic of /tf are read; None has no limit."""
        return [(None, None)] if self.all_topics[name].num <= _MAX_TF_MESSAGES else self._windows()

    def see_all_frames(self) -> None:
        """Reads all of /tf, because windows may have missed some of its frames."""
        if not self._has_all_of_tf:
            self._look_at_frames(all_of_tf=True)

    def _look_at_frames(self, all_of_tf: bool) -> None:
        names = [name for name in TF_TOPICS if name in self.all_topics]
        whole = [name for name in names if name.endswith("tf_static") or all_of_tf
                 or self.all_topics[name].num <= _MAX_TF_MESSAGES]
        for message in self.files.messages(whole) if whole else ():
            self.frames.add_message(message, self.left_out)
        parts = [name for name in names if name not in whole]
        for window in self._windows() if parts else ():
            for message in self.files.messages(parts, *window):
                self.frames.add_message(message, self.left_out)
        self._has_all_of_tf = not parts

    def _windows(self) -> list[tuple[int | None, int | None]]:
        if self.is_whole or not self.topics:
            return [(None, None)]
        begin = min(topic.begin_ns for topic in self.topics.values())
        end = max(topic.end_ns for topic in self.topics.values())
        starts = np.linspace(begin + 1e9 * _BEGIN_S, end - 1e9 * _WINDOW_S, _NUM_WINDOWS)
        windows: list[tuple[int | None, int | None]] = [(begin, begin + int(1e9 * _BEGIN_S))]
        # Limits are included, so a window begins after the end of the one before.
        return windows + [(int(start) + 1, int(start + 1e9 * _WINDOW_S)) for start in starts if start > begin]

    def _sample(self) -> Iterator[RawMessage]:
        for from_ns, until_ns in self._windows() if self.topics else ():
            yield from self.files.messages(list(self.topics), from_ns, until_ns)

    def _look_at(self, message: RawMessage) -> None:
        """Adds a message to the figures. One that cannot be read is only counted."""
        topic = self.topics[message.topic]
        try:
            stamp_ns, frame = message.header()
            topic.frames[frame] += 1
            topic.stamps_ns.append(stamp_ns)
            topic.records_ns.append(message.record_ns)
            if topic.topic.kind == ODOMETRY and len(topic.poses) < MAX_POSES:
                self._look_at_odometry(topic, message.make())
            elif topic.topic.kind == IMU and len(topic.forces) < MAX_POSES:
                force = message.make().linear_acceleration
                topic.forces.append((force.x, force.y, force.z))
            elif topic.topic.kind == CLOUD:
                self._look_at_cloud(topic, message.make(), stamp_ns)
            elif topic.name in self._cameras and self._is_wanted(topic):
                topic.clouds.append(cloud_samples.CloudSample(self._cameras[topic.name].cloud(message.make())))
        except ValueError as error:
            if len(topic.faults) < _MAX_FAULTS:
                topic.faults[str(error)] += 1

    def _look_at_cloud(self, topic: TopicSurvey, msg: Any, stamp_ns: int) -> None:
        """Looks at the points of some clouds, and at the layout of all. Raises ValueError if a cloud cannot be read."""
        layout = cloud_samples.layout_of(msg)
        if self._is_wanted(topic):
            topic.clouds.append(cloud_samples.CloudSample(msg))
            topic.times.judge(msg.data, layout, stamp_ns)
        problem = layout.problem(len(msg.data))
        if problem:
            raise ValueError(problem)

    def _is_wanted(self, topic: TopicSurvey) -> bool:
        """Returns whether a cloud is read: the first ones in a row are, and then pairs among the rest.

        Pairs show the time between sweeps, by which the unit of point times is judged.
        """
        in_windows = int((_BEGIN_S + _NUM_WINDOWS * _WINDOW_S) * (topic.rate_hz or 0.0))
        seen, num_all = len(topic.stamps_ns), topic.topic.num if self.is_whole else in_windows
        step = max(2, 2 * num_all // _NUM_CLOUDS)
        return len(topic.clouds) < _NUM_CLOUDS and (seen <= _NUM_CLOUDS // 2 or seen % step < 2)

    @staticmethod
    def _look_at_odometry(topic: TopicSurvey, msg: Any) -> None:
        topic.children[frame_name(msg.child_frame_id)] += 1
        p, q = msg.pose.pose.position, msg.pose.pose.orientation
        T = voxnav.pose_from_quaternion((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
        topic.poses.append((p.x, p.y, p.z))
        for _, off_m in topic.lone_poses.add(Posed(msg.header.stamp.to_nsec(), T, None)):
            if off_m is not None:
                topic.faults[ALONE] += 1
