# SPDX-License-Identifier: BSD-3-Clause
"""Chooses the topics of a recording that are used, by their content rather than by their names, and tells why."""

from __future__ import annotations

from typing import Callable, List, NamedTuple

import numpy as np

from voxnav.recordings.cloud_samples import LIDAR_FIELDS
from voxnav.recordings.depth_images import IMAGE
from voxnav.recordings.errors import DatasetError
from voxnav.recordings.survey import CLOUD, IMU, ODOMETRY, Survey, TopicSurvey

# Clouds with a longer reach or more points than this are not preferred to each other.
_FAR_M, _MANY_POINTS = 30.0, 20_000

# What to do with messages of other types, from which clouds can be made.
_LIVOX = ("messages on {topic} are those of a Livox driver: play the bag beside the node livox_cloud, and record the "
          "clouds that it makes (docs/sensors.md)")
_RAW = ("messages on {topic} are the raw data of a sensor: play the bag beside the driver of the sensor, and record "
        "the clouds that it makes")
_WITHOUT_CLOUDS = {
    IMAGE: "if the images on {topic} are depths, map them with --depth-camera {topic}",
    "livox_ros_driver/CustomMsg": _LIVOX, "livox_ros_driver2/CustomMsg": _LIVOX,
    "velodyne_msgs/VelodyneScan": _RAW, "ouster_ros/PacketMsg": _RAW, "ouster_sensor_msgs/PacketMsg": _RAW,
    "rslidar_msgs/rslidarScan": _RAW, "pandar_msgs/PandarScan": _RAW, "hesai_lidar/PandarScan": _RAW}


class Choice(NamedTuple):
    """The topic that is used, or None if there is none; why: the reason, a sentence for people."""

    topic: TopicSurvey | None
    why: str


def choose(survey: Survey, kind: str, wanted: str, score: Callable[[TopicSurvey], float],
           figures: Callable[[TopicSurvey], str]) -> Choice:
    """Returns the topic of a kind with the highest score, or the one that is wanted by name.

    Raises DatasetError if no topic has that name.
    """
    found = survey.of_kind(kind)
    if wanted:
        named = [topic for topic in found if topic.name.lstrip("/") == wanted.lstrip("/")]
        if not named:
            raise DatasetError("no messages of type %s on %s" % (kind, wanted), "the bag has them on %s" % (
                ", ".join(topic.name for topic in found) or "no topic"))
        return Choice(named[0], "%s, as configured (%s)" % (named[0].name, figures(named[0])))
    if not found:
        return Choice(None, "none in the recording")
    ranked = sorted(found, key=lambda topic: (-score(topic), topic.name))
    why = "%s (%s)" % (ranked[0].name, figures(ranked[0]))
    if len(ranked) > 1:
        why += ", rather than " + "; ".join("%s (%s)" % (other.name, figures(other)) for other in ranked[1:])
    return Choice(ranked[0], why)


def _median(values: List[float]) -> float:
    return float(np.median(values)) if values else 0.0


def _share_of_time(topic: TopicSurvey, survey: Survey) -> float:
    """Returns the share of the recording's time that a topic covers."""
    begin = min(other.begin_ns for other in survey.topics.values())
    end = max(other.end_ns for other in survey.topics.values())
    return (topic.end_ns - topic.begin_ns) / max(end - begin, 1)


class CloudFigures:
    """The figures by which topics of clouds are compared: fields, rate and extent."""

    def __init__(self, topic: TopicSurvey, survey: Survey) -> None:
        good = [sample for sample in topic.clouds if sample.problem is None]
        self.is_readable = bool(good)
        self.problem = next((sample.problem for sample in topic.clouds if sample.problem), None)
        self.time_field = str(topic.times.report.field)
        self.num_lidar_fields = max((len(set(sample.fields) & set(LIDAR_FIELDS)) for sample in good), default=0)
        self.reach_m = _median([sample.reach_m for sample in good])
        self.horizon = _median([sample.horizon for sample in good])
        self.num_points = _median([sample.num_returns for sample in good])
        self.share_of_time = _share_of_time(topic, survey)
        self.rate_hz = topic.rate_hz
        origins = {other.frame for other in survey.of_kind(ODOMETRY)}
        self.is_in_the_world = topic.frame in origins

    def score(self) -> float:
        if not self.is_readable:
            return -100.0
        score = 3.0 * bool(self.time_field) + min(self.num_lidar_fields, 2) + 4.0 * self.horizon
        score += 3.0 * min(self.reach_m / _FAR_M, 1.0) + 2.0 * min(self.num_points / _MANY_POINTS, 1.0)
        score += 3.0 * self.share_of_time
        if self.rate_hz is None or not 2.0 <= self.rate_hz <= 60.0:
            score -= 6.0
        return score - 20.0 * self.is_in_the_world

    def words(self) -> str:
        if not self.is_readable:
            return "cannot be read: %s" % (self.problem or "no message of it was seen")
        words = ["%.1f Hz" % self.rate_hz if self.rate_hz else "one cloud",
                 "point times '%s'" % self.time_field if self.time_field else "no point times",
                 "%.0f points" % self.num_points, "95 %% within %.0f m" % self.reach_m,
                 "%.0f deg of the horizon" % (360.0 * self.horizon)]
        if self.is_in_the_world:
            words.append("already in the frame of the odometry")
        if self.share_of_time < 0.9:
            words.append("%.0f %% of the time" % (100.0 * self.share_of_time))
        return ", ".join(words)


def _hint_without_clouds(survey: Survey) -> str:
    """Returns what may help with a recording without clouds."""
    for name, topic in sorted(survey.all_topics.items()):
        if topic.kind in _WITHOUT_CLOUDS:
            return _WITHOUT_CLOUDS[topic.kind].format(topic=name)
    return "record the topic on which the driver of the LiDAR publishes its clouds"


def choose_cloud(survey: Survey, wanted: str) -> Choice:
    """Chooses the topic of the LiDAR. Raises DatasetError if the recording has no clouds."""
    if not survey.of_kind(CLOUD):
        raise DatasetError("the bag has no %s; its topics are %s" % (
            CLOUD, ", ".join(sorted(survey.all_topics)) or "none"), _hint_without_clouds(survey))
    return choose(survey, CLOUD, wanted, lambda topic: CloudFigures(topic, survey).score(),
                  lambda topic: CloudFigures(topic, survey).words())


def _overlap(topic: TopicSurvey, cloud: TopicSurvey) -> float:
    """Returns the share of the clouds' time that a topic covers."""
    common = min(topic.end_ns, cloud.end_ns) - max(topic.begin_ns, cloud.begin_ns)
    return float(np.clip(common / max(cloud.end_ns - cloud.begin_ns, 1), 0.0, 1.0))


def _is_mounted(survey: Survey, frame: str, cloud: TopicSurvey) -> bool:
    return frame == cloud.frame or (frame != "" and survey.frames.chain(frame, cloud.frame) is not None)


def _partner_words(topic: TopicSurvey, cloud: TopicSurvey, frame: str) -> str:
    rate = "%.0f Hz" % topic.rate_hz if topic.rate_hz else "one message"
    of = "of '%s'" % frame if frame else "without the name of a frame"
    return "%s, %s, %.0f %% of the clouds' time" % (rate, of, 100.0 * _overlap(topic, cloud))


def choose_odometry(survey: Survey, wanted: str, cloud: TopicSurvey) -> Choice:
    """Chooses the poses: preferred are a body on which the LiDAR's mount is known, and complete, frequent poses."""
    def score(topic: TopicSurvey) -> float:
        rate_hz = topic.rate_hz or 0.0
        return (4.0 * _is_mounted(survey, topic.child, cloud) + 6.0 * _overlap(topic, cloud)
                + min(rate_hz / 100.0, 1.0) - 6.0 * (not topic.poses))
    return choose(survey, ODOMETRY, wanted, score, lambda topic: _partner_words(topic, cloud, topic.child))


def choose_imu(survey: Survey, wanted: str, cloud: TopicSurvey) -> Choice:
    """Chooses the IMU: preferred are one whose mount is known, and samples that are complete and frequent."""
    def score(topic: TopicSurvey) -> float:
        rate_hz = topic.rate_hz or 0.0
        return (4.0 * _is_mounted(survey, topic.frame, cloud) + 6.0 * _overlap(topic, cloud)
                + min(rate_hz / 200.0, 1.0))
    return choose(survey, IMU, wanted, score, lambda topic: _partner_words(topic, cloud, topic.frame))
