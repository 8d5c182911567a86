# SPDX-License-Identifier: BSD-3-Clause
"""Wherever a bag is damaged, only the messages there are lost, none is invented, and all that are lost are counted."""

import random

import pytest

rosbag = pytest.importorskip("rosbag")
import rospy  # noqa: E402
from std_msgs.msg import String, UInt64MultiArray  # noqa: E402

from voxnav.recordings.bag_files import BagFiles  # noqa: E402
from voxnav.recordings.errors import DatasetError  # noqa: E402

TOPICS = ["/numbers", "/words"]
NUM_MESSAGES, CHUNK_BYTES = 240, 4000
MAGIC_BYTES = 13


def write_bag(path, compression):
    """Writes numbers with a payload that does not compress, and words in between; returns the bytes of the file."""
    draw = random.Random(1)
    with rosbag.Bag(path, "w", compression, chunk_threshold=CHUNK_BYTES) as bag:
        for i in range(NUM_MESSAGES):
            stamp = rospy.Time.from_sec(100.0 + 0.01 * i)
            if i % 3:
                bag.write("/words", String(data="word %d" % i), stamp)
            else:
                bag.write("/numbers", UInt64MultiArray(data=[draw.getrandbits(64) for _ in range(60)]), stamp)
    with open(path, "rb") as source:
        return source.read()


def read(path):
    """Returns {(topic, record time): bytes} of what can be read, the number that is said to be lost, and the rest."""
    files = BagFiles([path])
    try:
        found = [((message.topic, message.record_ns), message.data) for message in files.messages(TOPICS)]
        assert len(dict(found)) == len(found), "a message was read twice"
        counts = [files.left_out.count(what) + files.lost.count(what) for what in ("message", "part of the file")]
        return dict(found), counts[0], counts[1]
    finally:
        files.close()


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
@pytest.mark.parametrize("kind", ["zeros", "noise"])
def test_damage_anywhere_loses_what_is_there_and_counts_it(compression, kind, tmp_path):
    path = str(tmp_path / "flight.bag")
    content = write_bag(path, compression)
    intact = read(path)[0]
    assert len(intact) == NUM_MESSAGES
    per_chunk = max(chunk_sizes(path))
    draw = random.Random(2)
    for _ in range(60):
        length = draw.choice([1, 4, 30, 300])
        at = draw.randrange(MAGIC_BYTES, len(content) - length)
        damaged = bytes(length) if kind == "zeros" else bytes(draw.getrandbits(8) for _ in range(length))
        with open(path, "wb") as out:
            out.write(content[:at] + damaged + content[at + length:])
        found, num_lost, num_parts = read(path)
        assert not set(found) - set(intact), (at, length)
        changed = sum(intact[key] != data for key, data in found.items())
        missing = len(intact) - len(found)
        # Bytes of a payload bear no checksum, and words are so short that 300 bytes reach several.
        assert changed <= (0 if compression == "bz2" else 1 + length // 40), (at, length)
        assert missing <= 2 * per_chunk, (at, length)
        assert num_lost == missing or num_parts > 0, (at, length)


def chunk_sizes(path):
    with rosbag.Bag(path) as bag:
        return [sum(chunk.connection_counts.values()) for chunk in bag._chunks]


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.9, 0.999])
def test_a_file_that_is_cut_off_is_read_up_to_there(compression, share, tmp_path):
    path = str(tmp_path / "flight.bag")
    content = write_bag(path, compression)
    intact = read(path)[0]
    with open(path, "wb") as out:
        out.write(content[:int(share * len(content))])
    found = read(path)[0]
    assert all(intact[key] == data for key, data in found.items())
    assert share * NUM_MESSAGES - max_loss() <= len(found) <= NUM_MESSAGES


def max_loss():
    """Returns how many messages a cut may cost: the index takes a part of the file, and a chunk is packed as one."""
    return NUM_MESSAGES // 10


def test_nothing_is_read_from_a_file_that_is_no_bag(tmp_path):
    path = str(tmp_path / "flight.bag")
    with open(path, "wb") as out:
        out.write(bytes(1000))
    with pytest.raises(DatasetError, match="not a readable bag: it does not begin"):
        BagFiles([path])
