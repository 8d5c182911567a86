# SPDX-License-Identifier: BSD-3-Clause
"""RealTime and WaitingSimulation have the same methods; in a simulation that waits, work is done once per map."""

import threading

import numpy as np
import pytest

rospy = pytest.importorskip("rospy")
pytest.importorskip("voxnav.msg")
time_seam = pytest.importorskip("voxnav.nodes.time_seam")
from voxnav.planning_manager import Plan  # noqa: E402


class Progress:
    def __init__(self):
        self.stamps = []

    def publish(self, stamp):
        self.stamps.append(stamp)

    def listen(self, act):
        self.announce = act


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


def test_a_lost_map_is_announced_and_everything_happens_without_it(seam):
    seen = []
    seam.every(10.0, lambda: seen.append(seam.now().to_sec()))
    seam.wait_for(lambda now_s: True)
    seam._progress.announce(49.9)
    assert seen == [50.0]
    assert [stamp.to_sec() for stamp in seam._progress.stamps] == [49.9]


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


class Search(str):
    """An item of work whose time the test sets."""


def executor_with(seam, duration_s, run, **kwargs):
    return seam.executor("worker", run, time_seam.WorkTimes({Search: (duration_s, duration_s)}, 1), **kwargs)


def instants(clocks, seam, count):
    """Lets maps arrive at 10 Hz."""
    for _ in range(count):
        clocks.ros_s = round(clocks.ros_s + 0.1, 6)
        seam.map_arrived(clocks.ros_s - time_seam.SWEEP_S)


@pytest.mark.parametrize("acts_last", [False, True])
def test_simulated_work_takes_simulated_time(clocks, seam, acts_last):
    began, ended = [], []

    def run(item):
        began.append((str(item), seam.now().to_sec()))
        return lambda: ended.append((str(item), seam.now().to_sec()))

    executor = executor_with(seam, 0.32, run, acts_last=acts_last)
    executor.submit(Search("a"))
    executor.submit(Search("b"))
    assert began == ([] if acts_last else [("a", 50.0)]) and not ended
    instants(clocks, seam, 10)
    assert ended == [("a", 50.3), ("b", 50.6)], "one after another, at the instants nearest to the due times"
    assert began == (ended if acts_last else [("a", 50.0), ("b", 50.3)])


def test_work_that_submits_work_ends_first(clocks, seam):
    order = []

    def run(item):
        if item == "a":
            executor.submit(Search("nested"))
        return lambda: order.append(str(item))

    executor = executor_with(seam, 0.1, run)
    executor.submit(Search("a"))
    instants(clocks, seam, 3)
    assert order == ["a", "nested"]


def test_simulated_work_that_waits_is_bounded(seam):
    executor = executor_with(seam, 1.0, lambda item: None)
    for _ in range(time_seam.MAX_WAITING_ITEMS + 5):
        executor.submit(Search("a"))
    assert len(executor._waiting) == time_seam.MAX_WAITING_ITEMS


def test_durations_of_work_follow_from_their_seed():
    def draws(seed):
        times = time_seam.WorkTimes({Search: (0.1, 0.3)}, seed)
        return [times.draw_s(Search("a")) for _ in range(100)]

    assert draws(1) == draws(1) != draws(2)
    assert 0.1 <= min(draws(1)) < 0.13 and 0.27 < max(draws(1)) <= 0.3
    assert time_seam.WorkTimes({Search: (0.0, 0.0)}, 1).are_zero


def test_results_of_work_are_used_in_both_kinds_of_time(seam):
    for kind in (seam, time_seam.RealTime()):
        done = threading.Event()
        kind.executor("worker", lambda item: done.set).submit("job")
        assert done.wait(10.0)


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


@pytest.mark.parametrize("error, words", [(ValueError("no map"), "no map"), (MemoryError(), "MemoryError"),
                                          (KeyError("x"), "'x'")])
def test_no_failure_of_an_action_ends_the_thread_that_does_it(clocks, error, words):
    node_module = pytest.importorskip("voxnav.nodes.planning_manager")
    node, told = object.__new__(node_module.PlanningManagerNode), []

    class Manager:
        @staticmethod
        def failed(action, problem, _):
            told.append((action, problem))
            return ["again"]

    node._lock, node._manager, node._seam = threading.RLock(), Manager, time_seam.RealTime()
    node._dispatch = told.append
    action = Plan(1, np.zeros(3), np.ones(3))
    with node._failures_answered(action):
        raise error
    assert told == [(action, words), ["again"]]
