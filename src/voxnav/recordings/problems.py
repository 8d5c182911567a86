# SPDX-License-Identifier: BSD-3-Clause
"""Lists what is wrong with a recording, and what to do about each problem."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import voxnav
from voxnav.recordings.clocks import TopicClock
from voxnav.recordings.left_out import LeftOut
from voxnav.recordings.plan import RecordingPlan, clock_distance_s
from voxnav.recordings.survey import TopicSurvey

# Topics with a longer period have too few messages in a window to judge their stamps.
_SLOW_PERIOD_S = 0.3
_GRAVITY_MPS2 = 9.81


class Problem(NamedTuple):
    """A problem and its remedy as sentences; to_do is empty if nothing can be done about it."""

    what: str
    to_do: str = ""


def used_topics(plan: RecordingPlan) -> list[tuple[str, TopicSurvey]]:
    """Returns the topics that are used, each with the name of its messages."""
    used = (("cloud", plan.cloud), ("odometry", plan.odometry), ("IMU", plan.imu))
    return ([(what, topic) for what, topic in used if topic is not None]
            + [(sensor.what, sensor.topic) for sensor in plan.further])


def problems_of(plan: RecordingPlan) -> list[Problem]:
    """Returns all problems; one that prevents mapping comes first."""
    out = [Problem(plan.error)] if plan.error else []
    out += [Problem(warning) for warning in plan.warnings]
    for what, topic in used_topics(plan):
        out += _clock_problems(plan, what, topic) + _gap_problems(plan, what, topic)
    if plan.cloud is not None:
        out += _cloud_problems(plan.cloud) + _imu_problems(plan, plan.cloud)
    for sensor in plan.further:
        out += [Problem("%s: %s" % (sensor.topic.name, each.what), each.to_do)
                for each in _cloud_problems(sensor.topic)]
    return out


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
    found = [Problem("%s: %s" % (topic.name, line), "nothing: the others are used") for line in left_out.lines()[:5]]
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
    bad = [sample for sample in cloud.clouds if sample.problem is not None]
    out = []
    if bad:
        out.append(Problem("%d of %d clouds that were looked at cannot be read: %s" % (
            len(bad), len(cloud.clouds), bad[0].problem), "they are left out; see the driver's settings"))
    times = cloud.times.report
    if times.problem:
        out.append(Problem(times.problem, "see the driver's settings; motion within these sweeps is not undone"))
    if cloud.clouds and times.state == voxnav.TimesState.NO_FIELD:
        out.append(Problem("the points bear no times: motion within a sweep cannot be undone",
                           "record the driver's own topic, with its field for time (t, time, timestamp)"))
    return out


def _imu_problems(plan: RecordingPlan, cloud: TopicSurvey) -> list[Problem]:
    if plan.odometry is not None:
        return []
    if plan.imu is None:
        return [Problem("there is neither odometry nor an IMU: nothing tells where down is",
                        "record the LiDAR's own IMU; until then the map is as level as the LiDAR was at the beginning")]
    out = []
    apart_s = clock_distance_s(plan.imu, cloud)
    if apart_s > 1.0:
        out.append(Problem("the clocks of %s and %s are %.1f s apart" % (plan.imu.name, cloud.name, apart_s),
                           "let both be stamped by one clock (PTP, or the time of reception); the IMU is of no use so"))
    if imu_unit(plan.imu) is None:
        out.append(Problem("the accelerations on %s are neither of m/s^2 nor of g: their size is %.3g" % (
            plan.imu.name, force_size(plan.imu)), "see the driver's settings; only their direction is used"))
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
