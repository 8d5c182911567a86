# SPDX-License-Identifier: BSD-3-Clause
"""Lists what is wrong with a recording, and what to do about each problem."""

from __future__ import annotations

import numpy as np

import voxnav
from voxnav.recordings.clocks import TopicClock
from voxnav.recordings.depth_images import IMAGE
from voxnav.recordings.errors import Problem
from voxnav.recordings.left_out import LeftOut
from voxnav.recordings.plan import RecordingPlan, clock_distance_s
from voxnav.recordings.survey import TopicSurvey

_USE_OF_OTHERS = "nothing: the others are used; if there are many, see the node that sends them"
# Topics with a longer period have too few messages in a window to judge their stamps.
_SLOW_PERIOD_S = 0.3
_GRAVITY_MPS2 = 9.81


def used_topics(plan: RecordingPlan) -> list[tuple[str, TopicSurvey]]:
    """Returns the topics that are used, each with the name of its messages."""
    used = (("cloud", plan.cloud), ("odometry", plan.odometry), ("IMU", plan.imu))
    return ([(what, topic) for what, topic in used if topic is not None]
            + [(sensor.what, sensor.topic) for sensor in plan.further])


def problems_of(plan: RecordingPlan) -> list[Problem]:
    """Returns all problems; one that prevents mapping comes first."""
    out = [plan.failure.problem] if plan.failure else []
    out += plan.warnings
    for what, topic in used_topics(plan):
        out += _faults(topic) + _clock_problems(plan, what, topic) + _gap_problems(plan, what, topic)
    if plan.cloud is not None:
        out += _cloud_problems(plan.cloud) + _imu_problems(plan, plan.cloud)
    for sensor in plan.further:
        out += [Problem("%s: %s" % (sensor.topic.name, each.what), each.to_do)
                for each in _cloud_problems(sensor.topic)]
    return out


def _faults(topic: TopicSurvey) -> list[Problem]:
    """Returns what is wrong with single messages: they cannot be read, or are of another frame than the others."""
    usual = {"frame": topic.frame, "body": topic.child}
    others = [("its %s is '%s', that of the others '%s'" % (what, name, usual[what]), num)
              for what, names in (("frame", topic.frames), ("body", topic.children))
              for name, num in names.items() if name != usual[what]]
    return [Problem("%s: %d of %d messages that were looked at cannot be used: %s" % (
        topic.name, num, len(topic.stamps_ns), text), _USE_OF_OTHERS)
        for text, num in (list(topic.faults.items()) + others)[:5]]


def _clock_problems(plan: RecordingPlan, what: str, topic: TopicSurvey) -> list[Problem]:
    """Returns the problems that the clock of a topic will find when the recording is mapped."""
    if not plan.survey.is_whole and (topic.period_s or 0.0) > _SLOW_PERIOD_S:
        return []
    left_out = LeftOut()
    clock = TopicClock(what, left_out, topic.period_s, topic.offsets_ns)
    for stamp_ns, record_ns in zip(topic.stamps_ns, topic.records_ns):
        for _ in clock.add(stamp_ns, record_ns, None):
            pass
    for _ in clock.end():
        pass
    found = [Problem("%s: %s" % (topic.name, line), _USE_OF_OTHERS) for line in left_out.lines()[:5]]
    found += [Problem("%s: %s" % (topic.name, note), "let the clock be set before recording begins")
              for note in clock.notes[:5]]
    if topic.offset_ns is None and topic.stamps_ns:
        found.append(Problem("%s: its stamps and record times do not go together" % topic.name,
                             "a clock that was set cannot be told from a pause; record the flight, not a replay"))
    return found


def _gap_problems(plan: RecordingPlan, what: str, topic: TopicSurvey) -> list[Problem]:
    limit_s = plan.options.max_pose_gap_s if topic is plan.odometry else 1.0
    to_do = {"odometry": "LiDAR odometry covers it where run/pose_source is auto",
             "IMU": "LiDAR odometry goes on without it there"}.get(
                 what, "nothing of it is mapped there; check cable, network and disk of the recorder")
    gaps = [gap for gap in topic.gaps if gap.length_s > limit_s]
    if not gaps:
        return []
    longest = max(gaps, key=lambda gap: gap.length_s)
    text = "%s is silent %s longer than %.1f s, for %.1f s at %.3f" % (
        topic.name, "once" if len(gaps) == 1 else "%d times" % len(gaps), limit_s, longest.length_s, longest.at_s)
    return [Problem(text, to_do)]


def _cloud_problems(cloud: TopicSurvey) -> list[Problem]:
    if cloud.topic.kind == IMAGE:
        return []  # its pixels are of one time
    out = []
    times = cloud.times.report
    if times.problem:
        out.append(Problem(times.problem, "let the driver write the time of each point (its settings for time "
                           "stamps); until then, slow flights make better maps"))
    if cloud.clouds and times.state == voxnav.TimesState.NO_FIELD:
        out.append(Problem("the points bear no times: motion within a sweep cannot be undone",
                           "record the driver's own topic, with its field for time (t, time, timestamp)"))
    return out


def _imu_problems(plan: RecordingPlan, cloud: TopicSurvey) -> list[Problem]:
    if plan.odometry is not None:
        return []
    if plan.imu is None:
        return [Problem("there is neither odometry that can be used nor an IMU: nothing tells where down is",
                        "record the LiDAR's own IMU; until then the map is as level as the LiDAR was at the beginning")]
    out = []
    apart_s = clock_distance_s(plan.imu, cloud)
    if apart_s > 1.0:
        out.append(Problem("the clocks of %s and %s are %.1f s apart" % (plan.imu.name, cloud.name, apart_s),
                           "let both be stamped by one clock (PTP, or the time of reception); until then the IMU is "
                           "of no use"))
    if imu_unit(plan.imu) is None:
        out.append(Problem("the accelerations on %s are neither of m/s^2 nor of g: their size is %.3g" % (
            plan.imu.name, force_size(plan.imu)), "see the settings of its driver; only their direction is used"))
    return out


def force_size(imu: TopicSurvey) -> float:
    """Returns the median magnitude of the accelerations that were read, or NaN if there are none."""
    return float(np.median(np.linalg.norm(np.array(imu.forces), axis=1))) if imu.forces else float("nan")


def imu_unit(imu: TopicSurvey) -> str | None:
    """Returns the unit of the accelerations by their usual magnitude, or None if it fits no unit."""
    size = force_size(imu)
    if 0.8 * _GRAVITY_MPS2 < size < 1.2 * _GRAVITY_MPS2:
        return "m/s^2"
    return "g" if 0.8 < size < 1.2 else None
