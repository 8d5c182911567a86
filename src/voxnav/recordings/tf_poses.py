# SPDX-License-Identifier: BSD-3-Clause
"""Composes the poses of the body from the links on /tf, each interpolated at the stamps of the one sent most often."""

from __future__ import annotations

from collections import Counter, deque
from typing import Any, Deque, Dict, Iterator, List, NamedTuple

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.recordings.bag_files import RawMessage, Topic
from voxnav.recordings.clocks import Stamped, TopicClock, clock_offsets_ns
from voxnav.recordings.frames import links_of
from voxnav.recordings.left_out import LeftOut
from voxnav.recordings.survey import MAX_POSES, ODOMETRY, Survey, TopicSurvey
from voxnav.recordings.tf_path import Ends, TfPath

_MAX_WAITING = 2000  # poses that wait for a link that is sent more rarely
_MAX_STAMPS = 500_000  # of each link that are looked at


class TfTrack(NamedTuple):
    """The moving links of a path. leading: the one that is sent most often; offsets_ns: their clocks (TopicClock)."""

    path: TfPath
    leading: Ends
    offsets_ns: Dict[Ends, List[int]]


def survey_track(survey: Survey, path: TfPath) -> tuple[TfTrack, TopicSurvey] | None:
    """Reads the moving links of a path. Returns them, and their figures as if they were a topic of odometry."""
    moving = [ends for ends in (survey.frames.ends(a, b) for a, b in zip(path.frames, path.frames[1:]))
              if survey.frames.is_moving(*ends)]
    stamps: Dict[Ends, List[int]] = {ends: [] for ends in moving}
    records: Dict[Ends, List[int]] = {ends: [] for ends in moving}
    poses: Dict[Ends, List[Array]] = {ends: [] for ends in moving}
    windows = survey.tf_windows(path.topic)
    for message in (message for window in windows for message in survey.files.messages([path.topic], *window)):
        for ends, stamp_ns, T in links_of(message, LeftOut()):
            if ends in stamps and len(stamps[ends]) < _MAX_STAMPS and stamps[ends][-1:] != [stamp_ns]:
                stamps[ends].append(stamp_ns)
                records[ends].append(message.record_ns)
                if len(poses[ends]) < MAX_POSES:
                    poses[ends].append(T)
    leading = max(moving, key=lambda ends: len(stamps[ends]))
    if not stamps[leading]:
        return None
    offsets_ns = {ends: clock_offsets_ns(np.array(stamps[ends], dtype=np.int64),
                                         np.array(records[ends], dtype=np.int64)) for ends in moving}
    track = TfTrack(path, leading, offsets_ns)
    num = len(stamps[leading])
    topic = TopicSurvey(Topic(path.topic, ODOMETRY, num), np.array(sorted(records[leading]), dtype=np.int64))
    if len(windows) > 1:  # the pauses between windows are none of the topic
        whole_ns = survey.files.record_times_ns(path.topic)
        topic.gaps, topic.begin_ns, topic.end_ns = [], int(whole_ns[0]), int(whole_ns[-1])
    topic.frames, topic.children = Counter({path.origin: num}), Counter({path.body: num})
    topic.stamps_ns, topic.records_ns = stamps[leading], records[leading]
    middle = {ends: rows[len(rows) // 2] for ends, rows in poses.items() if rows}
    topic.poses = [compose(survey, path, {**middle, leading: T})[:3, 3] for T in poses[leading]]
    return track, topic


def compose(survey: Survey, path: TfPath, moving: Dict[Ends, Array]) -> Array:
    """Returns T_O_B (4, 4) by the transforms of the moving links, T_parent_child (4, 4) each, and of the others."""
    T = np.eye(4)
    for a, b in zip(path.frames, path.frames[1:]):
        ends = survey.frames.ends(a, b)
        step = moving.get(ends)
        if step is None:
            T = T @ survey.frames.step(a, b)
        else:
            T = T @ (step if ends == (a, b) else np.linalg.inv(step))
    return T


class TfPoses:
    """Takes messages of /tf in the order of recording, and yields the poses of the body. Repeated ones count once.

    left_out: counts transforms with a wrong stamp, and poses for which a link is missing.
    """

    def __init__(self, survey: Survey, track: TfTrack, max_gap_s: float, left_out: LeftOut) -> None:
        self.clocks = {ends: TopicClock("transform %s to %s" % ends, left_out, None, offsets_ns)
                       for ends, offsets_ns in track.offsets_ns.items()}
        self._survey, self._track, self._left_out = survey, track, left_out
        self._max_gap_ns = int(1e9 * max_gap_s)
        self._newest_ns: Dict[Ends, int] = {}  # stamp of the newest message of each link, as it was sent
        self._known: Dict[Ends, Deque[Stamped]] = {ends: deque() for ends in track.offsets_ns if ends != track.leading}
        self._waiting: Deque[Stamped] = deque()  # transforms of the leading link

    def add(self, message: RawMessage) -> Iterator[Stamped]:
        """Adds a message. Yields poses with T_O_B (4, 4) as payload, whose stamps rise while the clock goes on."""
        for ends, stamp_ns, T in links_of(message, self._left_out):
            if ends not in self.clocks or self._newest_ns.get(ends) == stamp_ns:
                continue
            self._newest_ns[ends] = stamp_ns
            for stamped in self.clocks[ends].add(stamp_ns, message.record_ns, T):
                self._take(ends, stamped)
        yield from self._give(is_end=False)

    def end(self) -> Iterator[Stamped]:
        """Ends the recording, and yields the poses that waited for another link."""
        for ends, clock in self.clocks.items():
            for stamped in clock.end():
                self._take(ends, stamped)
        yield from self._give(is_end=True)

    def _take(self, ends: Ends, stamped: Stamped) -> None:
        kept = self._waiting if ends == self._track.leading else self._known[ends]
        if kept and stamped.stamp_ns < kept[-1].stamp_ns:
            kept.clear()  # the clock was set back, so that what is from before fits nothing that comes
        kept.append(stamped)

    def _give(self, is_end: bool) -> Iterator[Stamped]:
        while self._waiting:
            first = self._waiting[0]
            late = [ends for ends, known in self._known.items() if not known or known[-1].stamp_ns < first.stamp_ns]
            if late and not is_end and len(self._waiting) <= _MAX_WAITING:
                return
            self._waiting.popleft()
            moving: Dict[Ends, Any] = {ends: self._at(ends, first.stamp_ns) for ends in self._known}
            silent = [ends for ends, T in moving.items() if T is None]
            if silent:
                self._left_out.add("odometry", "there is no transform from %s to %s at its time" % silent[0],
                                   first.stamp_ns)
                continue
            moving[self._track.leading] = first.payload
            yield first._replace(payload=compose(self._survey, self._track.path, moving))

    def _at(self, ends: Ends, stamp_ns: int) -> Array | None:
        """Returns the transform of a link at a stamp, or None outside of those that are known and within gaps."""
        known = self._known[ends]
        while len(known) > 1 and known[1].stamp_ns <= stamp_ns:
            known.popleft()
        if not known or known[0].stamp_ns > stamp_ns:
            return None
        before, after = known[0], known[1] if len(known) > 1 else known[0]
        if before.stamp_ns == stamp_ns:
            T: Array = before.payload
            return T
        if after.stamp_ns < stamp_ns or after.stamp_ns - before.stamp_ns > self._max_gap_ns:
            return None
        ratio = (stamp_ns - before.stamp_ns) / (after.stamp_ns - before.stamp_ns)
        out: Array = voxnav.interpolate_pose(before.payload, after.payload, ratio)
        return out
