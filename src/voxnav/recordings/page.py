# SPDX-License-Identifier: BSD-3-Clause
"""Writes a page that describes what is in a recording and how voxnav will use it."""

from __future__ import annotations

import os
from typing import Sequence

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.recordings.plan import RecordingPlan
from voxnav.recordings.problems import force_size, imu_unit, problems_of, used_topics
from voxnav.recordings.survey import TopicSurvey

# Measured memory of the interpreter with the core, and of an entry in the index of rosbag.
_BASE_MB, _INDEX_BYTES = 110.0, 700.0
_ROWS = {"cloud": "clouds", "odometry": "odometry", "IMU": "IMU"}


def page(plan: RecordingPlan, paths: Sequence[str], title: str = "recording") -> list[str]:
    """Returns the lines of the page, for people."""
    lines = _row(title, _files(plan, paths))
    for what, topic in used_topics(plan):
        if what in _ROWS:
            lines += _row(_ROWS[what], _topic_words(plan, what, topic))
    for sensor in plan.further:
        x, y, z = sensor.T_B_L[:3, 3]
        lines += _row("clouds", "%s; %d messages, '%s', at %.3f %.3f %.3f m on the body: %s" % (
            sensor.topic.name, sensor.topic.topic.num, sensor.topic.frame, x, y, z, sensor.how))
    for what in ("odometry", "IMU"):
        if what not in [name for name, _ in used_topics(plan)] and plan.cloud is not None:
            lines += _row(what, plan.why[what] or "none")
    lines += _row("mount", _mount_words(plan)) + _row("point times", _time_words(plan))
    if plan.imu is not None:
        lines += _row("gravity", _gravity_words(plan.imu))
    if plan.origin_m is not None:
        lines += _row("origin", "positions are far from their origin (UTM?): %s m is subtracted from all of them" %
                      " ".join("%.0f" % value for value in plan.origin_m))
    lines += _row("not used", _unused(plan)) + _row("memory", _memory_words(plan))
    problems = problems_of(plan)
    lines.append("problems" + ("" if problems else "     none"))
    for number, problem in enumerate(problems, 1):
        lines.append("  %d. %s%s" % (number, problem.what, ("\n     -> " + problem.to_do) if problem.to_do else ""))
    return lines


def _row(name: str, text: str) -> list[str]:
    return ["%-12s %s" % (name, text)] if text else []


def _files(plan: RecordingPlan, paths: Sequence[str]) -> str:
    topics = plan.survey.topics.values()
    text = "%s, %.1f MB" % (", ".join(os.path.basename(path) for path in paths), 1e-6 * plan.survey.files.size_bytes)
    if topics:
        begin, end = min(topic.begin_ns for topic in topics), max(topic.end_ns for topic in topics)
        text += ", %.1f s from %.3f" % (1e-9 * (end - begin), 1e-9 * begin)
    return text + ("" if plan.survey.is_whole else "; looked at in windows")


def _topic_words(plan: RecordingPlan, what: str, topic: TopicSurvey) -> str:
    name = {"cloud": "clouds"}.get(what, what)
    frame = "'%s'" % topic.frame if topic.frame else "no frame"
    if topic is plan.odometry:
        frame = "%s to %s" % (frame, "'%s'" % topic.child if topic.child else "a body without a name")
    return "%s; %d messages, %s" % (plan.why[name], topic.topic.num, frame)


def _mount_words(plan: RecordingPlan) -> str:
    if plan.mount is None:
        return "unknown"
    x, y, z = plan.mount.T_B_L[:3, 3]
    roll, pitch, yaw = np.round(np.degrees(_rpy_of(plan.mount.T_B_L)), 1) + 0.0  # no minus before zero
    return "LiDAR at %.3f %.3f %.3f m, roll pitch yaw %.1f %.1f %.1f deg on '%s': %s" % (
        x, y, z, roll, pitch, yaw, plan.mount.body, plan.mount.how)


def _rpy_of(T: Array) -> tuple[float, float, float]:
    """Returns fixed-axis roll, pitch and yaw in radians."""
    R = T[:3, :3]
    return (float(np.arctan2(R[2, 1], R[2, 2])), float(np.arcsin(np.clip(-R[2, 0], -1.0, 1.0))),
            float(np.arctan2(R[1, 0], R[0, 0])))


def _time_words(plan: RecordingPlan) -> str:
    if plan.cloud is None or plan.cloud.times.report.state == voxnav.TimesState.NO_FIELD:
        return "none"
    return plan.cloud.times.report.how


def _gravity_words(imu: TopicSurvey) -> str:
    if not imu.forces:
        return "the IMU shows nothing"
    mean = np.mean(np.array(imu.forces), axis=0)
    up = mean / max(float(np.linalg.norm(mean)), 1e-9)
    return "median of the accelerations %.3g, which is of %s; up is along (%.2f %.2f %.2f) of '%s'" % (
        force_size(imu), imu_unit(imu) or "an unknown unit", up[0], up[1], up[2], imu.frame)


def _unused(plan: RecordingPlan) -> str:
    used = {topic.name for _, topic in used_topics(plan)}
    others = [topic for name, topic in sorted(plan.survey.all_topics.items())
              if name not in used and not name.lstrip("/").startswith("tf")]
    words = ["%s (%d %s)" % (topic.name, topic.num, topic.kind.split("/")[-1]) for topic in others[:12]]
    return ", ".join(words) + (" and %d topics more" % (len(others) - 12) if len(others) > 12 else "")


def _memory_words(plan: RecordingPlan) -> str:
    """Returns a rough figure of the memory for messages that are kept and for the program itself."""
    if plan.cloud is None:
        return ""
    index_mb = 1e-6 * _INDEX_BYTES * sum(topic.num for topic in plan.survey.all_topics.values())
    bytes_each = max((sample.num_bytes for sample in plan.cloud.clouds), default=0)
    waiting_mb = 1e-6 * bytes_each * min(plan.cloud.topic.num, 2 + int(1.0 / plan.sweep_s))
    return "about %.0f MB to begin with (%.0f MB of them the index of the bag), and the map" % (
        _BASE_MB + index_mb + waiting_mb, index_mb)
