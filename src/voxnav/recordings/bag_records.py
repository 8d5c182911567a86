# SPDX-License-Identifier: BSD-3-Clause
"""Finds the records of a rosbag, also behind damaged bytes.

A file is a sequence of records: a header of named fields, one of which is the kind of the record, and data. Chunks are
records whose data is again a sequence of records, possibly compressed.
Source: ROS wiki, Bags/Format/2.0.
"""

from __future__ import annotations

import enum
import mmap
import struct
from typing import Dict, Iterator, NamedTuple, Union

Content = Union[bytes, mmap.mmap]

MAGIC = b"#ROSBAG V2.0\n"
# A header holds a few short fields, or in a connection's data the definition of a message.
MAX_HEADER_BYTES = 1 << 24


class Kind(enum.IntEnum):
    """The kinds of records, with the numbers that the format gives them."""

    MESSAGE = 2
    FILE_HEADER = 3
    INDEX = 4
    CHUNK = 5
    CHUNK_INFO = 6
    CONNECTION = 7


class Record(NamedTuple):
    """A record, and where it and its data begin and end."""

    kind: Kind
    fields: Dict[str, bytes]
    at: int
    begin: int
    end: int


def fields_of(content: Content, at: int, end: int) -> Dict[str, bytes]:
    """Returns the fields of a header that fills content[at:end]. Raises ValueError if they do not."""
    out = {}
    while at < end:
        size = length_at(content, at)
        name, equals, value = content[at + 4:at + 4 + size].partition(b"=")
        if at + 4 + size > end or not equals:
            raise ValueError("a field of a header is damaged")
        out[name.decode("ascii", "replace")] = value
        at += 4 + size
    return out


def length_at(content: Content, at: int) -> int:
    """Returns the length that is stored at a place. Raises ValueError if the file ends before."""
    try:
        return int(struct.unpack_from("<I", content, at)[0])
    except struct.error:
        raise ValueError("the file ends within a record")


def record_at(content: Content, at: int) -> Record:
    """Returns the record that begins at a place. Raises ValueError if there is none; its data may be cut off."""
    length = length_at(content, at)
    if length > MAX_HEADER_BYTES:
        raise ValueError("a header is too long")
    fields = fields_of(content, at + 4, at + 4 + length)
    begin = at + 8 + length
    return Record(Kind(field(fields, "op", "<B")), fields, at, begin, begin + length_at(content, begin - 4))


def field(fields: Dict[str, bytes], name: str, form: str) -> int:
    """Returns a field as a number. Raises ValueError if it is missing or has another length."""
    try:
        return int(struct.unpack(form, fields[name])[0])
    except (KeyError, struct.error):
        raise ValueError("the field %s of a header is damaged" % name)


def time_of(fields: Dict[str, bytes], name: str) -> int:
    """Returns a field that is a time, in ns. Raises ValueError if it is missing."""
    time = field(fields, name, "<Q")  # 32 bits of seconds and 32 bits of nanoseconds
    return (time & 0xFFFFFFFF) * 10**9 + (time >> 32)


def next_record(content: Content, kind: Kind, at: int) -> Record | None:
    """Returns the first record of a kind that begins at a place or after it, None if there is none. O(n)."""
    mark = struct.pack("<I", 4) + b"op=" + bytes([kind])
    # Writers in Python put the kind first, and those in C++ sort the fields by name.
    before = (0, 4 + len("conn=1234"), 4 + len("compression=bz2"), 4 + len("compression=none"))
    found = content.find(mark, at)
    while found >= 0:
        for place in (found - 4 - length for length in before):
            if place < at:
                continue
            try:
                record = record_at(content, place)
            except ValueError:
                continue
            if record.kind is kind:
                return record
        found = content.find(mark, found + 1)
    return None


def records(content: Content, at: int, end: int, wanted: Kind) -> Iterator[Record | None]:
    """Yields the records between two places, and None where something is damaged.

    After damage the next record is the next one of the kind `wanted`, which is looked for from the beginning of the
    last intact record on, because the length of that record may be what is damaged.
    """
    last = at - 1
    while at < end:
        record: Record | None
        try:
            record = record_at(content, at)
            if record.end > end:
                raise ValueError("a record is longer than what holds it")
        except ValueError:
            yield None
            record = next_record(content, wanted, last + 1)
            if record is None or record.at >= end:
                return
            last = record.at  # the search goes on behind it even if it is cut off
            if record.end > end:
                continue
        yield record
        last, at = record.at, record.end
