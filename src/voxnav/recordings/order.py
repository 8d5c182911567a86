# SPDX-License-Identifier: BSD-3-Clause
"""Sorts messages of several topics by the time that they describe, whatever the order of their recording."""

from __future__ import annotations

import heapq
from typing import Any, Dict, Iterator, List, NamedTuple

# All three bound the messages that wait for other topics: clouds have many bytes, and IMU samples are many.
MAX_WAIT_NS = 10_000_000_000  # in record time
MAX_BYTES = 512 * 1024 * 1024
MAX_RECORDS = 200_000


class Ordered(NamedTuple):
    """A message with due_ns, its stamp or for a cloud the end of its sweep, and record_ns, its record time."""

    due_ns: int
    record_ns: int
    num_bytes: int
    payload: Any


class TopicOrder:
    """Yields a record once every topic that still has messages has reached its time, or if too much waits.

    topics: the topics whose messages are added here; each must be ended by end().
    """

    def __init__(self, topics: List[str]) -> None:
        self.num_forced = 0  # records that were yielded because too much waited
        self._reached_ns: Dict[str, int | None] = {topic: None for topic in topics}
        self._waiting: List[tuple[int, int, Ordered]] = []  # heap: due, number, record
        self._num_added = self._num_bytes = self._newest_record_ns = 0

    def add(self, topic: str, record: Ordered) -> Iterator[Any]:
        """Adds a record, whose times rise within its topic, and yields payloads that no later record can precede."""
        if topic in self._reached_ns:
            self._reached_ns[topic] = record.due_ns
        self._num_added += 1
        self._num_bytes += record.num_bytes
        self._newest_record_ns = max(self._newest_record_ns, record.record_ns)
        heapq.heappush(self._waiting, (record.due_ns, self._num_added, record))
        yield from self._give()

    def end(self, topic: str) -> Iterator[Any]:
        """Ends a topic, so that no record waits for it any more."""
        self._reached_ns.pop(topic, None)
        yield from self._give()

    def _give(self) -> Iterator[Any]:
        reached = list(self._reached_ns.values())
        known = [due_ns for due_ns in reached if due_ns is not None]
        until_ns = min(known, default=2**63) if len(known) == len(reached) else None
        while self._waiting:
            is_certain = until_ns is not None and self._waiting[0][0] <= until_ns
            if not is_certain and not self._is_too_much():
                return
            self.num_forced += not is_certain
            record = heapq.heappop(self._waiting)[2]
            self._num_bytes -= record.num_bytes
            yield record.payload

    def _is_too_much(self) -> bool:
        return (self._newest_record_ns - self._waiting[0][2].record_ns > MAX_WAIT_NS or self._num_bytes > MAX_BYTES
                or len(self._waiting) > MAX_RECORDS)
