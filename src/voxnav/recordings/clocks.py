# SPDX-License-Identifier: BSD-3-Clause
"""Corrects the stamps of one topic: a lone outlier is dropped, and a lasting jump begins a new clock.

A recording holds the record time of each message and the messages after it, which a vehicle in flight does not know. So
no message of a new clock is lost, a jump of the stamps can be told from a pause of the sensor, and stamps from before
the clock was set are moved to the clock of the rest.
"""

from __future__ import annotations

import heapq
from typing import Any, Iterator, NamedTuple, Sequence

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.recordings.left_out import REPEATED, LeftOut

# Steps between stamps that are larger than this, or than a few periods of a slow sensor, may be jumps of the clock.
_STEP_NS = 1_000_000_000
_PERIODS = 5.0
_NUM_CONFIRMING = 3  # number of messages in a row that confirm a clock
_NUM_SWAPPED = 2  # number of messages that may be recorded before messages with earlier stamps
_NUM_STUCK = 3  # number of repetitions of a stamp after which the clock counts as standing still
_MAX_NOTES = 100
_MAX_CLOCKS = 20
_MAX_SPREAD_NS = 5 * _STEP_NS  # if the lag of record times varies by more, they are those of a replay


class Stamped(NamedTuple):
    """A message of a topic. stamp_ns: its stamp, which may be corrected; record_ns: the time of its recording."""

    stamp_ns: int
    record_ns: int
    payload: Any


def clock_offsets_ns(stamps_ns: Array, records_ns: Array) -> list[int]:
    """Returns by how much the stamps of a topic are ahead of its record times, for each clock that made stamps.

    The clock with most messages comes first. The list is empty if no clock made most of the stamps, as record times do
    not help then. stamps_ns, records_ns: (n,) int64 of the same messages. O(n log n).
    """
    offsets = np.sort(np.asarray(stamps_ns, dtype=np.int64) - np.asarray(records_ns, dtype=np.int64))
    clocks = np.split(offsets, np.flatnonzero(np.diff(offsets) > _STEP_NS) + 1)
    clocks = [clock for clock in clocks if len(clock) and clock[-1] - clock[0] <= _MAX_SPREAD_NS]
    clocks.sort(key=len, reverse=True)
    if not clocks or 2 * len(clocks[0]) <= len(offsets):
        return []
    return [int(np.median(clock)) for clock in clocks[:_MAX_CLOCKS]]


class TopicClock:
    """Corrects the stamps of one topic in the order of recording. It holds back at most four messages.

    what: the name of the messages in ``left_out``. period_s: the time between messages, None if it is unknown.
    offsets_ns: the result of clock_offsets_ns().
    """

    def __init__(self, what: str, left_out: LeftOut, period_s: float | None = None,
                 offsets_ns: Sequence[int] = ()) -> None:
        self.notes: list[str] = []  # lasting jumps and clocks that stood still, for people
        self._what, self._left_out, self._offsets_ns = what, left_out, offsets_ns
        self._max_step_ns = max(_STEP_NS, int(1e9 * _PERIODS * (period_s or 0.0)))
        self._watch = voxnav.ClockWatch(self._max_step_ns, self._max_step_ns, _NUM_CONFIRMING)
        self._newest: Stamped | None = None  # newest message of the present clock, as recorded
        self._num_on_clock = 0
        self._strays: list[Stamped] = []  # messages on another clock that is not confirmed yet
        self._shift_ns = 0  # added to stamps of the present clock
        self._waiting: list[tuple[int, int, Stamped]] = []  # heap of the present clock: stamp, number, message
        self._ready: list[Stamped] = []  # messages of the clock before
        self._num_waited = 0
        self._newest_out_ns: int | None = None
        self._num_repeated = 0

    def add(self, stamp_ns: int, record_ns: int, payload: Any) -> Iterator[Stamped]:
        """Adds a message, and yields those that are certain by now, with rising stamps."""
        message = Stamped(stamp_ns, record_ns, payload)
        if stamp_ns == 0:
            self._leave_out(message, "its stamp is zero")
            return
        verdict = self._watch.add(stamp_ns)
        if verdict == voxnav.StampVerdict.STRAY:
            self._strays.append(message)
            self._drop_strays(keep=_NUM_CONFIRMING - 1)
        elif verdict == voxnav.StampVerdict.NEW_CLOCK:
            self._begin_clock(self._strays + [message])
        else:
            self._drop_strays(keep=0)
            if self._newest is None:
                self._choose_shift([message])
            self._believe(message)
        yield from self._give(_NUM_SWAPPED)

    def end(self) -> Iterator[Stamped]:
        """Ends the topic, and yields the messages that were held back."""
        self._drop_strays(keep=0)
        yield from self._give(0)

    def _begin_clock(self, messages: list[Stamped]) -> None:
        before, first = self._newest, messages[0]
        self._strays = []
        if before is not None and self._num_on_clock == 1:
            # No message confirmed the clock of the only message before, so it is an outlier.
            self._waiting = []
            self._leave_out(before, self._stray_reason(before, first))
        elif before is not None:
            jump_s = 1e-9 * _away_ns(first, before)
            if abs(jump_s) > 1e-9 * self._max_step_ns:
                self._note("the clock of %s messages was set by %+.3f s, to %.3f" % (
                    self._what, jump_s, 1e-9 * first.stamp_ns))
        self._ready += [message for _, _, message in sorted(self._waiting)]
        self._waiting, self._num_on_clock = [], 0
        self._choose_shift(messages)
        for message in messages:
            self._believe(message)

    def _choose_shift(self, messages: list[Stamped]) -> None:
        """Sets the shift that moves a clock far from the usual one to it, by the difference in record times."""
        self._shift_ns = 0
        if not self._offsets_ns:
            return
        measured_ns = int(np.median([m.stamp_ns - m.record_ns for m in messages]))
        known_ns = min(self._offsets_ns, key=lambda offset_ns: abs(offset_ns - measured_ns))
        if abs(known_ns - measured_ns) > self._max_step_ns:
            known_ns = measured_ns
        if abs(known_ns - self._offsets_ns[0]) > self._max_step_ns:
            self._shift_ns = self._offsets_ns[0] - known_ns

    def _believe(self, message: Stamped) -> None:
        if self._newest is None or message.stamp_ns >= self._newest.stamp_ns or self._num_on_clock == 0:
            self._newest = message
        self._num_on_clock += 1
        if self._shift_ns and self._num_on_clock == _NUM_CONFIRMING:
            self._note("%s messages from stamp %.3f on are %+.3f s off the clock of the rest and were moved to it" % (
                self._what, 1e-9 * message.stamp_ns, -1e-9 * self._shift_ns))
        self._num_waited += 1
        moved = message._replace(stamp_ns=message.stamp_ns + self._shift_ns)
        heapq.heappush(self._waiting, (moved.stamp_ns, self._num_waited, moved))

    def _give(self, keep: int) -> Iterator[Stamped]:
        ready, self._ready = self._ready, []
        for message in ready:
            yield from self._out(message)
        while len(self._waiting) > keep:
            yield from self._out(heapq.heappop(self._waiting)[2])

    def _out(self, message: Stamped) -> Iterator[Stamped]:
        newest_ns = self._newest_out_ns
        if newest_ns is not None and message.stamp_ns == newest_ns:
            self._num_repeated += 1
            if self._num_repeated == _NUM_STUCK:
                self._note("the clock of %s messages stood still at %.3f" % (self._what, 1e-9 * message.stamp_ns))
            self._leave_out(message, REPEATED)
        elif newest_ns is not None and newest_ns - self._max_step_ns < message.stamp_ns < newest_ns:
            self._leave_out(message, "it is older than others that were recorded before it")
        else:
            self._num_repeated, self._newest_out_ns = 0, message.stamp_ns
            yield message

    def _drop_strays(self, keep: int) -> None:
        while len(self._strays) > keep:
            message = self._strays.pop(0)
            self._leave_out(message, self._stray_reason(message, self._newest or message))

    @staticmethod
    def _stray_reason(message: Stamped, other: Stamped) -> str:
        return "its stamp is alone, %+.1f s off the others" % (1e-9 * _away_ns(message, other))

    def _leave_out(self, message: Stamped, reason: str) -> None:
        self._left_out.add(self._what, reason, message.stamp_ns)

    def _note(self, text: str) -> None:
        if len(self.notes) < _MAX_NOTES:
            self.notes.append(text)


def _away_ns(message: Stamped, other: Stamped) -> int:
    """Returns by how much the clock of one message is ahead of that of another."""
    return (message.stamp_ns - other.stamp_ns) - (message.record_ns - other.record_ns)
