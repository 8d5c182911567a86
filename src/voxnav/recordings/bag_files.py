# SPDX-License-Identifier: BSD-3-Clause
"""Reads rosbags as one stream of messages in the order of their recording, even if parts of the files are damaged."""

from __future__ import annotations

import heapq
import os
import struct
import tempfile
import weakref
from typing import Any, Iterator, NamedTuple, Sequence

import numpy as np

from voxnav.array_types import Array
from voxnav.recordings.bag_index import BagIndex
from voxnav.recordings.bag_records import MAGIC
from voxnav.recordings.bag_salvage import DAMAGED, salvage
from voxnav.recordings.errors import DatasetError, Problem
from voxnav.recordings.left_out import LeftOut


class Topic(NamedTuple):
    """A topic of all files together. kind: its message type, for example ``sensor_msgs/Imu``."""

    name: str
    kind: str
    num: int


class RawMessage(NamedTuple):
    """A message as bytes of the file. record_ns: the time at which it was recorded."""

    topic: str
    record_ns: int
    data: bytes
    kind: Any

    def make(self) -> Any:
        """Returns the message. Raises ValueError if its bytes do not fit its type."""
        msg = self.kind()
        try:
            msg.deserialize(self.data)
        except Exception as error:  # generated readers fail in many ways on damaged bytes
            raise ValueError("its bytes do not fit its type: %s" % error)
        return msg

    def header(self) -> tuple[int, str]:
        """Returns (stamp in ns, frame id without a leading slash) of a message that begins with a std_msgs/Header.

        The rest of the message is not read. Raises ValueError if the message is shorter than a header.
        """
        try:
            _, seconds, nanoseconds, length = struct.unpack_from("<IIII", self.data)
        except struct.error:
            raise ValueError("it is shorter than a header")
        if len(self.data) < 16 + length:
            raise ValueError("it is shorter than its header")
        return seconds * 10**9 + nanoseconds, frame_name(self.data[16:16 + length].decode("utf-8", "replace"))


TF_TOPICS = ("/tf_static", "tf_static", "/tf", "tf")


def frame_name(frame_id: str) -> str:
    """Returns a frame id in the form of tf2, without the leading slash of tf."""
    return str(frame_id).lstrip("/")


def _salvaged(path: str, left_out: LeftOut) -> tuple[Any, str]:
    """Returns a readable bag of what is intact of a bag that cannot be opened, and its path; counts what is lost."""
    import rosbag

    with open(path, "rb") as source:
        if source.read(len(MAGIC)) != MAGIC:
            raise DatasetError("%s: not a readable bag: it does not begin as one of version 2.0" % path)
    copy = tempfile.NamedTemporaryFile(suffix=".bag", delete=False)
    copy.close()
    try:
        if salvage(path, copy.name, left_out) == 0:
            raise ValueError("no message in it is intact")
        return rosbag.Bag(copy.name), copy.name
    except Exception as error:
        os.unlink(copy.name)
        raise DatasetError("%s: truncated or damaged, and nothing in it can be recovered: %s" % (path, error))


class BagFiles:
    """The bags of one recording, given in any order. Damaged messages are left out and counted in ``left_out``.

    lost: what could not be recovered of files that cannot be opened; it is known before anything is read.
    warnings: what is wrong with the files. Raises DatasetError naming the file that cannot be read.
    """

    def __init__(self, paths: Sequence[str]) -> None:
        self.warnings: list[Problem] = []
        self.left_out, self.lost = LeftOut(), LeftOut()
        self._bags: list[Any] = []
        self._indexes: list[BagIndex] = []
        # Copies are removed even if the files are not closed, for example because of an exception.
        self._copies: list[weakref.finalize] = []  # type: ignore[type-arg]
        self.size_bytes = 0
        try:
            for path in paths:
                self._open(path)
        except DatasetError:
            self.close()
            raise

    def _open(self, path: str) -> None:
        import rosbag  # imported here, so that folders of raw scans can be mapped without ROS

        if not os.path.exists(path):
            raise DatasetError("%s: no such file" % path)
        self.size_bytes += os.path.getsize(path)
        try:
            bag = rosbag.Bag(path)
            index = BagIndex(bag)
        except Exception:  # the reader fails in many ways on damaged bytes
            lost = LeftOut()
            bag, copy = _salvaged(path, lost)
            self.lost.take(lost)
            index = BagIndex(bag)
            self._copies.append(weakref.finalize(self, os.unlink, copy))
            self.warnings.append(Problem(
                "; ".join(["%s was not closed properly (truncated?), or is damaged; what is intact is used" % path] +
                          lost.lines()),
                "copy it again if the copy was interrupted; end recordings with Ctrl-C, and wait until the file has "
                "lost the ending .active"))
        self._bags.append(bag)
        self._indexes.append(index)
        self.warnings += [Problem(note, "set the clock before recording begins; the times of this recording are mended")
                          for note in self._indexes[-1].notes]

    def close(self) -> None:
        for bag in self._bags:
            bag.close()
        for remove in self._copies:
            remove()
        self._bags, self._indexes, self._copies = [], [], []

    def topics(self) -> dict[str, Topic]:
        """Returns the topics that have messages, by name."""
        out: dict[str, Topic] = {}
        for bag in self._bags:
            for name, info in bag.get_type_and_topic_info().topics.items():
                if info.message_count:
                    known = out[name].num if name in out else 0
                    out[name] = Topic(name, info.msg_type, known + info.message_count)
        return out

    def record_times_ns(self, topic: str) -> Array:
        """Returns the sorted record times (n,) int64 of a topic from the index, without reading its messages."""
        return np.sort(np.concatenate([index.times_ns(topic) for index in self._indexes]))

    def messages(self, topics: Sequence[str], from_ns: int | None = None,
                 until_ns: int | None = None) -> Iterator[RawMessage]:
        """Yields messages of some topics in the order of their record times; both limits are included."""
        streams = [self._of(bag, *index.places(topics, from_ns, until_ns))
                   for bag, index in zip(self._bags, self._indexes)]
        yield from heapq.merge(*streams, key=lambda message: message.record_ns)

    def _of(self, bag: Any, times_ns: Array, places: Array) -> Iterator[RawMessage]:
        """Reads messages one by one, because rosbag would stop at the first damaged one."""
        damaged_chunk = None
        has_chunks = hasattr(bag._reader, "decompressed_chunk_pos")
        for record_ns, (chunk, offset, index_ns, connection) in zip(times_ns.tolist(), places.tolist()):
            if chunk == damaged_chunk:
                self._count_damage(record_ns)
                continue
            try:
                position = (chunk, offset) if has_chunks else chunk
                topic, (_, data, _, _, kind), stamp = bag._read_message(position, raw=True)
                if stamp.to_nsec() != index_ns or topic != bag._connections[connection].topic:
                    raise ValueError("the index leads to another message")
            except Exception:  # the reader fails in many ways on damaged bytes
                # A chunk that cannot be decompressed is lost as a whole; otherwise only this message is lost.
                if has_chunks and bag._reader.decompressed_chunk_pos != chunk:
                    damaged_chunk = chunk
                self._count_damage(record_ns)
                continue
            yield RawMessage(topic, record_ns, data, kind)

    def _count_damage(self, record_ns: int) -> None:
        self.left_out.add("message", DAMAGED, record_ns)
