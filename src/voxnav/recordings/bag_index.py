# SPDX-License-Identifier: BSD-3-Clause
"""Reads the record time and the place of each message of a bag from the index at the end of the file."""

from __future__ import annotations

from typing import Any, Dict, List, Sequence

import numpy as np

from voxnav.array_types import Array

# If record times of one topic fall by more than this in the order of the file, the clock of the recorder was set back.
_STEP_NS = 1_000_000_000


class BagIndex:
    """Record times in nanoseconds and places of the messages of a bag.

    If the clock of the recorder was set back, earlier record times are moved so that all of them rise.
    notes: sentences on what was moved. Raises ValueError if the index is damaged. O(n log n) for n messages, with 40
    bytes for each.
    """

    def __init__(self, bag: Any) -> None:
        self.notes: List[str] = []
        self._bag = bag
        self._times: Dict[int, Array] = {}  # record times by connection
        self._places: Dict[int, Array] = {}  # by connection, as places() returns them
        bag._get_indexes(None)  # makes rosbag read the index
        for connection, index in bag._connection_indexes.items():
            self._times[connection] = np.array([entry.time.to_nsec() for entry in index], dtype=np.int64)
            self._places[connection] = np.array([_place(entry.position) + (entry.time.to_nsec(), connection)
                                                 for entry in index], dtype=np.int64).reshape(-1, 4)
        self._check()
        if any(np.any(np.diff(times) < -_STEP_NS) for times in self._times.values()):
            self._undo_steps()

    def _check(self) -> None:
        """Raises ValueError if a message was not recorded between the first and the last time of its chunk.

        rosbag does not look at what it reads from the index: damaged bytes there would lead to other messages.
        """
        chunks = sorted((chunk.pos, chunk.start_time.to_nsec(), chunk.end_time.to_nsec())
                        for chunk in getattr(self._bag, "_chunks", ()))
        if not chunks:  # files of version 1.2 have none
            return
        limits = np.array(chunks, dtype=np.int64)
        for places in self._places.values():
            of_chunk = limits[np.searchsorted(limits[:, 0], places[:, 0])]
            if np.any((places[:, 2] < of_chunk[:, 1]) | (places[:, 2] > of_chunk[:, 2])):
                raise ValueError("the index of a chunk is damaged")

    def _undo_steps(self) -> None:
        """Moves record times before a step back of the clock, so that they come before those after it.

        The file is in the order of recording. The clock is assumed to be right at the end, because somebody set it.
        """
        connections = [connection for connection, times in self._times.items() if len(times)]
        times = np.concatenate([self._times[connection] for connection in connections])
        places = np.concatenate([self._places[connection] for connection in connections])
        order = np.lexsort((places[:, 1], places[:, 0]))
        steps = np.diff(times[order])
        back = np.where(steps < -_STEP_NS, steps, 0)
        moves = np.empty(len(times), dtype=np.int64)
        moves[order] = np.concatenate([np.cumsum(back[::-1])[::-1], [0]])
        for at in np.flatnonzero(back)[:20]:
            self.notes.append("the clock of the recorder was set by %+.3f s at %.3f; what was recorded before is moved "
                              "along" % (1e-9 * back[at], 1e-9 * times[order][at]))
        first = 0
        for connection in connections:
            last = first + len(self._times[connection])
            self._times[connection] = times[first:last] + moves[first:last]
            first = last

    def _chosen(self, topics: Sequence[str]) -> List[int]:
        wanted = self._bag._get_connections(list(topics)) if topics else []
        return sorted(connection.id for connection in wanted if connection.id in self._times)

    def times_ns(self, topic: str) -> Array:
        """Returns the sorted record times (n,) int64 of a topic."""
        times = [self._times[connection] for connection in self._chosen([topic])]
        return np.sort(np.concatenate(times)) if times else np.empty(0, dtype=np.int64)

    def places(self, topics: Sequence[str], from_ns: int | None, until_ns: int | None) -> tuple[Array, Array]:
        """Returns record times (n,) and places (n, 4) int64, sorted by time; both limits are included.

        A place is the chunk, the offset in it, the record time as the file has it, and the connection.
        """
        chosen = self._chosen(topics)
        if not chosen:
            return np.empty(0, dtype=np.int64), np.empty((0, 4), dtype=np.int64)
        times = np.concatenate([self._times[connection] for connection in chosen])
        order = np.argsort(times, kind="stable")
        first = 0 if from_ns is None else int(np.searchsorted(times[order], from_ns, "left"))
        last = len(times) if until_ns is None else int(np.searchsorted(times[order], until_ns, "right"))
        order = order[first:last]
        return times[order], np.concatenate([self._places[connection] for connection in chosen])[order]


def _place(position: Any) -> tuple[int, int]:
    """Returns (chunk, offset). Files of version 1.2 have no chunks, so each message counts as a chunk."""
    return (position[0], position[1]) if isinstance(position, tuple) else (position, 0)
