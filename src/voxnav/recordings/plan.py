# SPDX-License-Identifier: BSD-3-Clause
"""Plans the use of a recording: its topics, mount and origin, and what is wrong with it."""

from __future__ import annotations

from typing import Any, NamedTuple, Tuple

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.recordings import choice, origin
from voxnav.recordings.bag_files import BagFiles
from voxnav.recordings.depth_images import IMAGE, DepthImages
from voxnav.recordings.errors import DatasetError, Problem
from voxnav.recordings.mount import Mount, find_further_mount, find_mount
from voxnav.recordings.survey import CLOUD, ODOMETRY, Survey, TopicSurvey
from voxnav.recordings.tf_path import find_tf_path
from voxnav.recordings.tf_poses import TfTrack, survey_track

# The duration of a sweep is the time between clouds, limited to this range.
_MIN_SWEEP_S, _MAX_SWEEP_S = 0.02, 0.5
# Topics whose stamps are farther apart than this, by record time, run on different clocks.
_OTHER_CLOCK_NS = 2_000_000_000


class BagOptions(NamedTuple):
    """Options of the user. Topics that are empty are chosen by their content.

    T_B_L: (4, 4) mount of the LiDAR on the body; None takes it from the transforms of the recording.
    max_pose_gap_s: the longest time between two poses over which they are interpolated.
    further_cloud_topics: those of other sensors, which are mapped as well. depth_cameras: the same for topics of depth
    images, with the DepthCloudConfig of each. odometry_frame: the frame of poses on /tf, where no topic has odometry.
    """

    cloud_topic: str = ""
    odometry_topic: str = ""
    imu_topic: str = ""
    T_B_L: Array | None = None
    pose_source: voxnav.PoseSource = voxnav.PoseSource.AUTO
    use_imu: bool = True
    max_pose_gap_s: float = 0.3
    further_cloud_topics: Tuple[str, ...] = ()
    depth_cameras: Tuple[Tuple[str, Any], ...] = ()
    odometry_frame: str = ""


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

    failure: the reason if nothing can be mapped, else None. warnings: assumptions, and what is not used. Attributes
    that are unknown because of it are None.
    """

    def __init__(self, files: BagFiles, options: BagOptions) -> None:
        self.options = options
        self.failure: DatasetError | None = None
        self.warnings: list[Problem] = []
        images = [name for name, topic in files.topics().items() if topic.kind == IMAGE]
        named = {name.lstrip("/"): name for name in images}
        self.cameras = {named[topic.lstrip("/")]: DepthImages(named[topic.lstrip("/")], config)
                        for topic, config in options.depth_cameras if topic.lstrip("/") in named}
        self.survey = Survey(files, self.cameras)
        self.cloud: TopicSurvey | None = None
        self.odometry: TopicSurvey | None = None
        self.imu: TopicSurvey | None = None
        self.tf_track: TfTrack | None = None  # the transforms that are the odometry, if no messages of it are used
        self.why = {"clouds": "", "odometry": "", "IMU": ""}
        self.mount: Mount | None = None
        self.further: list[FurtherSensor] = []
        self.origin_m: Array | None = None
        self._mount_notes: list[Problem] = []
        try:
            self._choose()
        except DatasetError as error:
            self.failure = error
        self.warnings += files.warnings + self.survey.frames.warnings + self._mount_notes
        self.warnings += [Problem(line, "see the node that publishes it; the others are used")
                          for line in self.survey.left_out.lines()]

    def _choose(self) -> None:
        options, survey = self.options, self.survey
        found = self._choose_cloud()
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

    def _choose_cloud(self) -> choice.Choice:
        """Returns the choice of the LiDAR, or of a depth camera if there are no clouds."""
        if not self.options.cloud_topic and not self.survey.of_kind(CLOUD) and self.options.depth_cameras:
            camera = self._camera(self.options.depth_cameras[0][0])
            return choice.Choice(camera, "%s, depth images, because the recording has no clouds" % camera.name)
        return choice.choose_cloud(self.survey, self.options.cloud_topic)

    def _camera(self, wanted: str) -> TopicSurvey:
        """Returns a topic of depth images. Raises DatasetError if it is none of the recording."""
        for name in self.cameras:
            if name.lstrip("/") == wanted.lstrip("/"):
                return self.survey.topics[name]
        images = sorted(name for name, topic in self.survey.all_topics.items() if topic.kind == IMAGE)
        raise DatasetError("no images on %s" % wanted, "the bag has images on %s" % (", ".join(images) or "no topic"))

    def _choose_further(self, cloud: TopicSurvey, mount: Mount) -> list[FurtherSensor]:
        out: list[FurtherSensor] = []
        topics = [choice.choose_cloud(self.survey, name).topic for name in self.options.further_cloud_topics]
        cameras = [self._camera(name) for name, _ in self.options.depth_cameras]
        for topic in topics + [camera for camera in cameras if camera is not cloud]:
            assert topic is not None
            if topic is cloud or any(topic is other.topic for other in out):
                raise DatasetError("the sensor on %s is asked for twice" % topic.name)
            T_B_L, how = find_further_mount(self.survey, cloud, topic, mount)
            out.append(FurtherSensor(topic, T_B_L, how))
        return out

    def _choose_odometry(self, cloud: TopicSurvey) -> choice.Choice:
        """Returns the choice of odometry, without a topic if LiDAR odometry is better or the only source of poses."""
        source = self.options.pose_source
        if source == voxnav.PoseSource.LIDAR:
            return choice.Choice(None, "not wanted (run/pose_source is lidar): poses come from LiDAR odometry")
        found = choice.choose_odometry(self.survey, self.options.odometry_topic, cloud)
        if not self.options.odometry_topic and (found.topic is None or self.options.odometry_frame):
            found = self._choose_tf(cloud) or found
        problem = Problem("the recording has no odometry", "run/pose_source: auto takes LiDAR odometry")
        if found.topic is not None:
            unusable = self._odometry_problem(found.topic, cloud)
            if unusable is None:
                return found
            problem = unusable
            self.warnings.append(Problem(problem.what + "; poses come from LiDAR odometry instead", problem.to_do))
        self.tf_track = None
        if source == voxnav.PoseSource.RECORDING:
            raise DatasetError("run/pose_source is 'recording', but " + problem.what, problem.to_do)
        return choice.Choice(None, problem.what + ": poses come from LiDAR odometry")

    def _choose_tf(self, cloud: TopicSurvey) -> choice.Choice | None:
        """Returns the choice of poses that are on /tf only, or None if no transforms move like a vehicle."""
        path = find_tf_path(self.survey, cloud, self.options.odometry_frame)
        found = None if path is None else survey_track(self.survey, path)
        if found is None:
            return None
        self.tf_track, topic = found
        why = "%s, transforms %s" % (topic.name, " -> ".join(self.tf_track.path.frames))
        if topic.rate_hz:
            why += " (%.0f Hz)" % topic.rate_hz
        if not self.survey.of_kind(ODOMETRY):
            why += ", because no topic has odometry"
        return choice.Choice(topic, why)

    def _odometry_problem(self, topic: TopicSurvey, cloud: TopicSurvey) -> Problem | None:
        limit_s = self.options.max_pose_gap_s
        if not topic.poses:
            return Problem("no message on %s that was looked at holds a pose" % topic.name,
                           "see the node that publishes it, or name another topic as run/odometry_topic")
        if clock_distance_s(topic, cloud) > 1e-9 * _OTHER_CLOCK_NS:
            return Problem("the clocks of %s and %s are %.1f s apart" % (
                topic.name, cloud.name, clock_distance_s(topic, cloud)),
                "let both be stamped by one clock (PTP, or the time of reception), and record the flight again")
        if topic.period_s is not None and topic.period_s > limit_s:
            return Problem("poses on %s are %.2f s apart, farther than mapper/max_pose_gap_s (%.2f s)" % (
                topic.name, topic.period_s, limit_s),
                "record the odometry at its full rate; or raise mapper/max_pose_gap_s, if the vehicle moves so slowly "
                "and evenly that its poses may be interpolated")
        return None

    @property
    def error(self) -> str | None:
        """Returns why nothing can be mapped, with what to do about it, or None."""
        return None if self.failure is None else str(self.failure)

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
