# SPDX-License-Identifier: BSD-3-Clause
"""Plans the use of a recording: its topics, mount and origin, and what is wrong with it."""

from __future__ import annotations

from typing import NamedTuple, Tuple

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.recordings import choice, origin
from voxnav.recordings.bag_files import BagFiles
from voxnav.recordings.errors import DatasetError
from voxnav.recordings.mount import Mount, find_further_mount, find_mount
from voxnav.recordings.survey import Survey, TopicSurvey

# The duration of a sweep is the time between clouds, limited to this range.
_MIN_SWEEP_S, _MAX_SWEEP_S = 0.02, 0.5
# Topics whose stamps are farther apart than this, by record time, run on different clocks.
_OTHER_CLOCK_NS = 2_000_000_000


class BagOptions(NamedTuple):
    """Options of the user. Topics that are empty are chosen by their content.

    T_B_L: (4, 4) mount of the LiDAR on the body; None takes it from the transforms of the recording.
    max_pose_gap_s: the longest time between two poses over which they are interpolated.
    further_cloud_topics: those of other sensors, which are mapped as well.
    """

    cloud_topic: str = ""
    odometry_topic: str = ""
    imu_topic: str = ""
    T_B_L: Array | None = None
    pose_source: voxnav.PoseSource = voxnav.PoseSource.AUTO
    use_imu: bool = True
    max_pose_gap_s: float = 0.3
    further_cloud_topics: Tuple[str, ...] = ()


class FurtherSensor(NamedTuple):
    """Clouds that are mapped beside those of the LiDAR. T_B_L: (4, 4); how: where it is from, for people."""

    topic: TopicSurvey
    T_B_L: Array
    how: str

    @property
    def what(self) -> str:
        """How its clouds are called where they are left out."""
        return "cloud on %s" % self.topic.name


class RecordingPlan:
    """The topics, mount and origin of a recording that are used.

    error: the reason if nothing can be mapped, else None. warnings: assumptions, and what is not used. Attributes that
    are unknown because of an error are None.
    """

    def __init__(self, files: BagFiles, options: BagOptions) -> None:
        self.options = options
        self.error: str | None = None
        self.warnings: list[str] = []
        self.survey = Survey(files)
        self.cloud: TopicSurvey | None = None
        self.odometry: TopicSurvey | None = None
        self.imu: TopicSurvey | None = None
        self.why = {"clouds": "", "odometry": "", "IMU": ""}
        self.mount: Mount | None = None
        self.further: list[FurtherSensor] = []
        self.origin_m: Array | None = None
        self._mount_notes: list[str] = []
        try:
            self._choose()
        except DatasetError as error:
            self.error = str(error)
        self.warnings += files.warnings + self.survey.frames.warnings + self._mount_notes
        self.warnings += self.survey.left_out.lines()

    def _choose(self) -> None:
        options, survey = self.options, self.survey
        found = choice.choose_cloud(survey, options.cloud_topic)
        self.cloud, self.why["clouds"] = found.topic, found.why
        assert self.cloud is not None
        found = self._choose_odometry(self.cloud)
        self.odometry, self.why["odometry"] = found.topic, found.why
        found = choice.Choice(None, "not wanted (odometry/use_imu is false)")
        if options.use_imu:
            found = choice.choose_imu(survey, options.imu_topic, self.cloud)
        self.imu, self.why["IMU"] = found.topic, found.why
        self.origin_m = origin.origin_of(self.odometry.poses if self.odometry else [])
        self.mount = find_mount(survey, self.cloud, self.odometry, self.imu, options.T_B_L)
        self._mount_notes = self.mount.notes
        self.further = self._choose_further(self.cloud, self.mount)

    def _choose_further(self, cloud: TopicSurvey, mount: Mount) -> list[FurtherSensor]:
        out: list[FurtherSensor] = []
        for name in self.options.further_cloud_topics:
            topic = choice.choose_cloud(self.survey, name).topic
            assert topic is not None
            if topic is cloud or any(topic is other.topic for other in out):
                raise DatasetError("clouds on %s are asked for twice" % topic.name)
            T_B_L, how = find_further_mount(self.survey, cloud, topic, mount)
            out.append(FurtherSensor(topic, T_B_L, how))
        return out

    def _choose_odometry(self, cloud: TopicSurvey) -> choice.Choice:
        """Returns the choice of odometry, without a topic if LiDAR odometry is better or the only source of poses."""
        source = self.options.pose_source
        if source == voxnav.PoseSource.LIDAR:
            return choice.Choice(None, "not wanted (run/pose_source is lidar): poses come from LiDAR odometry")
        found = choice.choose_odometry(self.survey, self.options.odometry_topic, cloud)
        problem = "the recording has no odometry" if found.topic is None else self._odometry_problem(found.topic, cloud)
        if problem is None:
            return found
        if source == voxnav.PoseSource.RECORDING:
            raise DatasetError("run/pose_source is 'recording', but " + problem)
        if found.topic is not None:
            self.warnings.append(problem + "; poses come from LiDAR odometry instead")
        return choice.Choice(None, problem + ": poses come from LiDAR odometry")

    def _odometry_problem(self, topic: TopicSurvey, cloud: TopicSurvey) -> str | None:
        limit_s = self.options.max_pose_gap_s
        if not topic.poses:
            return "no message on %s that was looked at holds a pose" % topic.name
        if clock_distance_s(topic, cloud) > 1e-9 * _OTHER_CLOCK_NS:
            return "the clocks of %s and %s are %.1f s apart" % (
                topic.name, cloud.name, clock_distance_s(topic, cloud))
        if topic.period_s is not None and topic.period_s > limit_s:
            return "poses on %s are %.2f s apart, farther than mapper/max_pose_gap_s (%.2f s)" % (
                topic.name, topic.period_s, limit_s)
        return None

    @property
    def sweep_s(self) -> float:
        """Returns the duration of a turn of the LiDAR by the rate of its clouds."""
        return sweep_s_of(self.cloud)


def sweep_s_of(cloud: TopicSurvey | None) -> float:
    """Returns the duration of a turn of a sensor by the rate of its clouds."""
    period_s = cloud.stamp_period_s if cloud else None
    return float(np.clip(period_s or 0.1, _MIN_SWEEP_S, _MAX_SWEEP_S))


def clock_distance_s(a: TopicSurvey, b: TopicSurvey) -> float:
    """Returns how far apart stamps of two topics are that were recorded at the same time, or 0 if this is not known."""
    if a.offset_ns is None or b.offset_ns is None:
        return 0.0
    return 1e-9 * abs(a.offset_ns - b.offset_ns)
