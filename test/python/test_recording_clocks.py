# SPDX-License-Identifier: BSD-3-Clause
"""In the stamps of a recorded topic a lone outlier is dropped, a lasting jump is a new clock, and all else is kept."""

import numpy as np
import pytest

from voxnav.recordings.clocks import TopicClock, clock_offsets_ns
from voxnav.recordings.left_out import REPEATED, LeftOut

PERIOD_S, LATENCY_S, NUM = 0.1, 0.02, 40
S = 10**9


def stamped(shifts_s=None, record_shifts_s=None):
    """Returns (stamps, record times) of a topic in ns, of which those of some messages are shifted.

    shifts_s, record_shifts_s: {number of the message: shift in seconds}.
    """
    stamps = [int(S * (1000.0 + PERIOD_S * i)) for i in range(NUM)]
    records = [stamp + int(S * LATENCY_S) for stamp in stamps]
    for i, shift_s in (shifts_s or {}).items():
        stamps[i] += int(S * shift_s)
    for i, shift_s in (record_shifts_s or {}).items():
        records[i] += int(S * shift_s)
    return stamps, records


def run(stamps, records, offsets_ns=()):
    """Returns (numbers and stamps of the messages that come out, LeftOut, notes)."""
    left_out = LeftOut()
    clock = TopicClock("cloud", left_out, PERIOD_S, offsets_ns)
    out = []
    for i in sorted(range(len(stamps)), key=lambda i: (records[i], i)):
        out += clock.add(stamps[i], records[i], i)
    out += clock.end()
    return [(each.payload, each.stamp_ns) for each in out], left_out, clock.notes


def numbers(out):
    return [number for number, _ in out]


def test_good_stamps_are_not_changed():
    stamps, records = stamped()
    out, left_out, notes = run(stamps, records)
    assert out == list(enumerate(stamps)) and not left_out and notes == []


@pytest.mark.parametrize("away_s", [3600.0, -3600.0, 1.7e9, 20.0])
@pytest.mark.parametrize("at", [0, 1, 7, NUM - 1])
@pytest.mark.parametrize("knows_offset", [False, True])
def test_a_lone_outlier_loses_only_its_message(away_s, at, knows_offset):
    stamps, records = stamped({at: max(away_s, -999.0)})
    offsets_ns = clock_offsets_ns(np.array(stamps), np.array(records)) if knows_offset else ()
    out, left_out, _ = run(stamps, records, offsets_ns)
    assert numbers(out) == [i for i in range(NUM) if i != at]
    assert left_out.count("cloud") == 1 and "alone" in left_out.lines()[0]


def test_outliers_on_different_clocks_lose_only_their_messages():
    out, left_out, _ = run(*stamped({9: 3600.0, 10: -500.0, 20: 3600.0}))
    assert numbers(out) == [i for i in range(NUM) if i not in (9, 10, 20)]
    assert left_out.count("cloud") == 3


@pytest.mark.parametrize("jump_s", [3600.0, -900.0, 5.0])
@pytest.mark.parametrize("at", [5, 12])
def test_stamps_from_before_the_clock_was_set_are_moved_to_the_new_clock(jump_s, at):
    truth, records = stamped()
    stamps, _ = stamped({i: jump_s for i in range(at)})
    out, left_out, notes = run(stamps, records, clock_offsets_ns(np.array(stamps), np.array(records)))
    assert numbers(out) == list(range(NUM)) and not left_out
    assert np.max(np.abs(np.array([stamp for _, stamp in out]) - truth)) < 2e6
    assert any("set by" in note for note in notes) and any("moved" in note for note in notes)


def test_without_a_usual_offset_a_lasting_jump_is_a_new_clock_and_loses_nothing():
    stamps, records = stamped({i: -900.0 for i in range(20, NUM)})
    out, left_out, notes = run(stamps, records)
    assert out == list(enumerate(stamps)) and not left_out
    assert "set by -900.000 s" in notes[0]


def test_a_pause_of_the_sensor_is_no_jump_of_its_clock():
    pause = {i: 7.0 for i in range(20, NUM)}
    stamps, records = stamped(pause, pause)
    out, left_out, notes = run(stamps, records, [-int(S * LATENCY_S)])
    assert out == list(enumerate(stamps)) and not left_out and notes == []


def test_a_single_message_after_a_long_pause_is_an_outlier():
    stamps, records = stamped({NUM - 1: 3600.0}, {NUM - 1: 3600.0})
    assert numbers(run(stamps, records)[0]) == list(range(NUM - 1))


@pytest.mark.parametrize("swapped", [(10, 11), (0, 1), (30, 32)])
def test_messages_recorded_in_another_order_are_sorted(swapped):
    a, b = swapped
    stamps, records = stamped()
    records[a], records[b] = records[b], records[a]
    out, left_out, _ = run(stamps, records)
    assert out == list(enumerate(stamps)) and not left_out


def test_repeated_messages_are_left_out_and_reported():
    stamps, records = stamped()
    repeated = range(10, 13)
    out, left_out, _ = run(stamps + [stamps[i] for i in repeated], records + [records[i] + 1000 for i in repeated])
    assert numbers(out) == list(range(NUM))
    assert left_out.count("cloud") == 3 and left_out.count("cloud", but=REPEATED) == 0


def test_a_clock_that_stands_still_is_reported():
    stamps, records = stamped()
    stamps[20:30] = [stamps[20]] * 10
    out, left_out, notes = run(stamps, records)
    assert numbers(out) == list(range(21)) + list(range(30, NUM))
    assert left_out.count("cloud") == 9 and "stood still" in notes[0]


def test_zero_stamps_are_left_out_and_reported():
    stamps, records = stamped()
    stamps[3] = stamps[30] = 0
    out, left_out, _ = run(stamps, records)
    assert len(out) == NUM - 2 and "2 x cloud left out" in left_out.lines()[0] and "zero" in left_out.lines()[0]


def test_a_recording_of_one_message_is_used():
    assert numbers(run([5 * S], [6 * S])[0]) == [0]


def test_offsets_that_drift_are_no_usual_offset():
    stamps, records = stamped()
    assert clock_offsets_ns(np.array(stamps), np.array(records)) == [-int(S * LATENCY_S)]
    replayed_ns = np.arange(100) * S
    assert clock_offsets_ns(replayed_ns, replayed_ns // 10) == []
    assert clock_offsets_ns(np.empty(0), np.empty(0)) == []
    two_clocks, _ = stamped({i: 100.0 for i in range(5)})
    assert clock_offsets_ns(np.array(two_clocks), np.array(records)) == [
        -int(S * LATENCY_S), int(S * (100.0 - LATENCY_S))]


def test_reasons_are_bounded():
    left_out = LeftOut()
    for i in range(1000):
        left_out.add("cloud", "reason %d" % i, i)
    assert left_out.count("cloud") == 1000 and len(left_out.lines()) <= 201
    total = LeftOut()
    total.add("cloud", "reason 1", 7)
    total.take(left_out)
    assert total.count("cloud") == 1001
