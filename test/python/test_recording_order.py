# SPDX-License-Identifier: BSD-3-Clause
"""Messages of several topics are sorted by the time that they describe, whatever the order of their recording."""

import random

import pytest

from voxnav.recordings import order
from voxnav.recordings.order import Ordered, TopicOrder

S = 10**9


def shuffled(seed, late_s):
    """Returns (topic, record) of clouds and IMU samples in the order of their recording.

    The stamps of each topic rise; late_s: {topic: how much later its messages are recorded}.
    """
    generator = random.Random(seed)
    records = []
    for topic, period_s, num in (("points", 0.1, 30), ("imu", 0.005, 700)):
        late = late_s[topic]
        for i in range(num):
            due_ns = int(S * (period_s * i + (0.1 if topic == "points" else 0.0)))
            records.append((topic, Ordered(due_ns, due_ns + int(S * late), 100, (due_ns, topic, i))))
    records.sort(key=lambda item: (item[1].record_ns, generator.random()))
    return records


def run(records, topics=("points", "imu")):
    sorter, out = TopicOrder(list(topics)), []
    left = {topic: sum(name == topic for name, _ in records) for topic in topics}
    for topic, record in records:
        out += sorter.add(topic, record)
        left[topic] -= 1
        if not left[topic]:
            out += sorter.end(topic)
    return out, sorter


@pytest.mark.parametrize("late_s", [{"points": 0.0, "imu": 0.0}, {"points": 0.0, "imu": 0.3}, {"points": 2.0, "imu": 0},
                                    {"points": 0.0, "imu": 5.0}])
@pytest.mark.parametrize("seed", range(3))
def test_messages_come_in_the_order_of_their_due_times(late_s, seed):
    records = shuffled(seed, late_s)
    out, sorter = run(records)
    assert len(out) == len(records) and sorter.num_forced == 0
    assert [due for due, _, _ in out] == sorted(due for due, _, _ in out)


def test_no_message_waits_for_a_topic_that_has_ended():
    records = [record for record in shuffled(0, {"points": 0.0, "imu": 0.0})
               if record[0] == "points" or record[1].due_ns < S]
    out, sorter = run(records)
    assert len(out) == len(records) and sorter.num_forced == 0


def test_waiting_messages_are_bounded_by_time_and_bytes(monkeypatch):
    sorter = TopicOrder(["points", "imu"])
    assert list(sorter.add("points", Ordered(S, S, 10, "first"))) == []
    assert list(sorter.add("points", Ordered(2 * S, S + order.MAX_WAIT_NS + 1, 10, "second"))) == ["first"]
    assert sorter.num_forced == 1
    monkeypatch.setattr(order, "MAX_BYTES", 1000)
    assert list(sorter.add("points", Ordered(3 * S, S + order.MAX_WAIT_NS + 2, 1000, "third"))) == ["second"]
