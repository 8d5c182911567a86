# SPDX-License-Identifier: BSD-3-Clause
"""Copies what is intact of a rosbag that cannot be opened, and counts what is lost.

A bag cannot be opened if it was not closed, if it is cut off, or if bytes of its index or of the header of a chunk are
damaged. ``rosbag reindex`` mends the first two, and gives up everything behind the first damage.
"""

from __future__ import annotations

import bz2
import mmap
import types
from typing import Any, Dict, Iterator, NamedTuple

from voxnav.recordings.bag_records import (MAGIC, Content, Kind, Record, field, fields_of, length_at, record_at,
                                           records, time_of)
from voxnav.recordings.left_out import LeftOut

DAMAGED = "its part of the file is damaged"
UNCOUNTED = "it is damaged, and nothing tells how many messages it held"


class Connection(NamedTuple):
    """A topic of one publisher. header: type, md5sum, message_definition and what the publisher added."""

    topic: str
    header: Dict[str, str]


class Summary(NamedTuple):
    """What the end of a bag that was closed says. chunks: begin in ns and number of messages by the chunk's place."""

    connections: Dict[int, Connection]
    chunks: Dict[int, "tuple[int, int]"]
    is_whole: bool


def connection_of(content: Content, record: Record) -> Connection:
    header = fields_of(content, record.begin, record.end)
    topic = record.fields["topic"].decode("utf-8", "replace")
    text = {name: value.decode("utf-8", "replace") for name, value in header.items()}
    if not {"type", "md5sum", "message_definition"} <= set(text):
        raise ValueError("the description of topic %s is damaged" % topic)
    return Connection(topic, dict(text, topic=topic))


def summary_of(content: Content) -> Summary:
    """Reads the end of a bag as far as it is there and intact."""
    connections: Dict[int, Connection] = {}
    chunks: Dict[int, tuple[int, int]] = {}
    is_whole = False
    try:
        head = record_at(content, len(MAGIC))
        at = field(head.fields, "index_pos", "<Q")
        while 0 < at < len(content):
            record = record_at(content, at)
            if record.kind is Kind.CONNECTION:
                connections[field(record.fields, "conn", "<I")] = connection_of(content, record)
            elif record.kind is Kind.CHUNK_INFO:
                places = range(record.begin, record.end, 8)
                num = sum(length_at(content, place + 4) for place in places)
                chunks[field(record.fields, "chunk_pos", "<Q")] = time_of(record.fields, "start_time"), num
            at = record.end
        is_whole = len(chunks) == field(head.fields, "chunk_count", "<I") > 0
    except (ValueError, KeyError):
        pass  # what was read before the damage is used
    return Summary(connections, chunks, is_whole)


class Salvage:
    """Reads a damaged bag of version 2.0 from its beginning to its end."""

    def __init__(self, content: Content) -> None:
        self._content = content
        self._summary = summary_of(content)
        self._connections = dict(self._summary.connections)
        self._num_read: Dict[int, int] = {}  # by the chunk's place
        self._num_gaps = 0

    def messages(self) -> Iterator[tuple[Connection, int, bytes]]:
        """Yields connection, record time in ns and bytes of the intact messages in the order of the file."""
        for chunk in records(self._content, len(MAGIC), len(self._content), Kind.CHUNK):
            if chunk is None:
                self._num_gaps += 1
            elif chunk.kind is Kind.CHUNK:
                yield from self._messages_of(chunk)

    def _messages_of(self, chunk: Record) -> Iterator[tuple[Connection, int, bytes]]:
        self._num_read[chunk.at] = 0
        try:
            content, at, end = self._opened(chunk)
        except Exception:  # the libraries for compression fail in many ways on damaged bytes
            self._num_gaps += 1
            return
        for record in records(content, at, end, Kind.MESSAGE):
            try:
                if record is None:
                    raise ValueError("a message is damaged")
                if record.kind is Kind.CONNECTION:
                    connection = connection_of(content, record)
                    self._connections[field(record.fields, "conn", "<I")] = connection
                elif record.kind is Kind.MESSAGE:
                    connection = self._connections[field(record.fields, "conn", "<I")]
                    message = connection, time_of(record.fields, "time"), content[record.begin:record.end]
                    self._num_read[chunk.at] += 1
                    yield message
            except (ValueError, KeyError):  # an unknown connection is a KeyError
                self._num_gaps += 1

    def _opened(self, chunk: Record) -> tuple[Content, int, int]:
        """Returns the bytes of a chunk, and where its records begin and end in them."""
        size, compression = field(chunk.fields, "size", "<I"), chunk.fields["compression"]
        if compression == b"none":
            # The sizes of a chunk that was not finished are zero.
            end = len(self._content) if size == 0 else chunk.begin + size
            return self._content, chunk.begin, min(end, len(self._content))
        packed = self._content[chunk.begin:chunk.end]
        if compression == b"bz2":
            content = bz2.decompress(packed)
        elif compression == b"lz4":
            import roslz4  # only bags that are compressed with it need it

            content = roslz4.decompress(packed)
        else:
            raise ValueError("a compression that is not known")
        return content, 0, len(content)

    def count_lost(self, left_out: LeftOut) -> None:
        """Counts what was not read. Without the summary at the end of the file the number of messages is not known."""
        for place, (start_ns, num) in sorted(self._summary.chunks.items()):
            lost = num - self._num_read.get(place, 0)
            if lost > 0:
                left_out.add("message", DAMAGED, start_ns, lost)
        if not self._summary.is_whole and self._num_gaps:
            left_out.add("part of the file", UNCOUNTED, None, self._num_gaps)


def salvage(path: str, copy: str, left_out: LeftOut) -> int:
    """Writes the intact messages of a bag of version 2.0 to a new one, counts the lost ones, and returns how many were
    intact. O(size of the file), which is not read into memory as a whole.
    """
    import genpy
    import rosbag

    num = 0
    with open(path, "rb") as source, mmap.mmap(source.fileno(), 0, access=mmap.ACCESS_READ) as content, \
            rosbag.Bag(copy, "w") as out:
        reader = Salvage(content)
        kinds: Dict[str, str] = {}
        for connection, record_ns, data in reader.messages():
            kind = connection.header["type"]
            if kinds.setdefault(connection.topic, kind) != kind:
                before = kinds[connection.topic]
                left_out.add("message", "its topic %s had the type %s before" % (connection.topic, before), record_ns)
                continue
            out.write(connection.topic, _raw(connection, data), genpy.Time(0, record_ns), raw=True,
                      connection_header=connection.header)
            num += 1
        reader.count_lost(left_out)
    return num


def _raw(connection: Connection, data: bytes) -> tuple[str, bytes, str, Any]:
    """Returns a message as rosbag takes one whose type is not installed."""
    header = connection.header
    kind = types.SimpleNamespace(_md5sum=header["md5sum"], _full_text=header["message_definition"])
    return header["type"], data, header["md5sum"], kind
