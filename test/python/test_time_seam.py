# SPDX-License-Identifier: BSD-3-Clause
"""RealTime and WaitingSimulation have the same methods; in a simulation that waits, work is done once per map."""

import threading

import pytest

rospy = pytest.importorskip("rospy")
pytest.importorskip("voxnav.msg")
time_seam = pytest.importorskip("voxnav.nodes.time_seam")


class Progress:
    def __init__(self):
        self.stamps = []

    def publish(self, stamp):
        self.stamps.append(stamp)


@pytest.fixture
def clocks(monkeypatch):
    """Returns the ROS clock and wall time, which the test sets; timers are recorded instead of being started."""
    class Clocks:
        ros_s, wall_s, timers = 50.0, 7.0, []

    clocks = Clocks()
    clocks.timers = []
    monkeypatch.setattr(rospy.Time, "now", staticmethod(lambda: time_seam.exact_time(clocks.ros_s)))
    monkeypatch.setattr(time_seam.time, "monotonic", lambda: clocks.wall_s)
    monkeypatch.setattr(rospy, "Timer", lambda period, callback, reset: clocks.timers.append(callback))
    return clocks


@pytest.fixture
def seam(clocks):
    return time_seam.WaitingSimulation(Progress())


def test_both_kinds_of_time_have_the_same_methods():
    public = [{name for name in dir(kind) if not name.startswith("_")}
              for kind in (time_seam.RealTime, time_seam.WaitingSimulation)]
    assert public[0] == public[1]


def test_a_map_makes_everything_happen_in_order_at_one_instant(seam):
    seen = []
    for name in ("check", "tick"):
        seam.every(10.0, lambda name=name: seen.append((name, seam.now().to_sec())))
    seam.map_arrived(49.9)
    assert seen == [("check", 50.0), ("tick", 50.0)]
    assert [stamp.to_sec() for stamp in seam._progress.stamps] == [49.9]


def test_inputs_wait_for_the_first_map_that_is_newer(seam):
    taken = []
    seam.deliver(49.8, taken.append, "old")
    seam.deliver(49.9, taken.append, "as old as the map")
    assert not taken
    seam.map_arrived(49.9)
    assert taken == ["old"]
    seam.map_arrived(50.0)
    assert taken == ["old", "as old as the map"]


def test_the_cycle_waits_until_announced_inputs_have_arrived(seam):
    newest, seen = [49.95], []
    seam.wait_for(lambda now_s: newest[0] >= now_s)
    seam.every(10.0, lambda: seen.append(newest[0]))
    cycle = threading.Thread(target=seam.map_arrived, args=(49.9,))
    cycle.start()
    newest[0] = 50.0
    seam.arrived()
    cycle.join(10.0)
    assert seen == [50.0]


def test_timers_step_in_only_while_maps_are_missing(clocks, seam):
    calls = []
    seam.every(10.0, lambda: calls.append(clocks.ros_s))
    clocks.timers[0](None)
    assert calls == [50.0], "there has been no map yet"
    seam.map_arrived(49.9)
    clocks.timers[0](None)
    assert calls == [50.0, 50.0], "the map has made it happen"
    clocks.ros_s = 51.5
    clocks.timers[0](None)
    assert calls[-1] == 51.5


def test_no_timeout_passes_while_time_stands_still_or_only_simulated_time_runs(clocks, seam):
    mark = seam.mark()
    clocks.wall_s += 100.0
    assert seam.elapsed_s(mark) == 0.0
    clocks.ros_s += 5.0
    assert seam.elapsed_s(mark) == 5.0
    mark = seam.mark()
    clocks.ros_s += 100.0
    assert seam.elapsed_s(mark) == 0.0


def test_a_waiting_simulation_does_work_at_once(seam):
    done = []
    seam.executor("worker", done.append).submit("job")
    assert done == ["job"]


def test_real_time_takes_inputs_at_once_and_measures_by_wall_time(clocks):
    seam, taken = time_seam.RealTime(), []
    seam.deliver(99.0, taken.append, "input")
    assert taken == ["input"]
    mark = seam.mark()
    clocks.wall_s, clocks.ros_s = clocks.wall_s + 3.0, clocks.ros_s - 20.0
    assert seam.elapsed_s(mark) == 3.0
    seam.every(10.0, lambda: taken.append("tick"))
    clocks.timers[0](None)
    assert taken == ["input", "tick"]


def test_real_time_works_in_threads():
    done = threading.Event()
    where = []

    def work(item):
        where.append((item, threading.current_thread().name))
        done.set()

    time_seam.RealTime().executor("worker", work).submit("job")
    assert done.wait(10.0)
    assert where == [("job", "worker")]
