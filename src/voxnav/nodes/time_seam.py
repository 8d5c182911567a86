# SPDX-License-Identifier: BSD-3-Clause
"""The one place in the Python nodes that knows whether time is real, or that of a simulation that waits for them.

Both kinds offer the same: a clock, timers, executors for work, and a way for inputs into the node. The section `time`
of a node's parameters (voxnav.TimeConfig) chooses; everything else runs the same code on both.

Real time runs by itself: inputs are taken as they come, periodic work runs on timers, and other work in threads of its
own. A simulation that waits (lock-step) stands still at an instant after each local map: then everything is done that
there is to do, in a fixed order and at once, with the inputs up to that instant, so that a flight does not depend on
the machine.
"""

import collections
import contextlib
import queue
import random
import threading
import time

import rospy

from voxnav.msg import Progress

# The simulation stands still this long after the stamp of a local map, which is the begin of its sweep, for the map's
# consumers: the length of a sweep, as lockstep_lag_s in simulation.launch.
SWEEP_S = 0.1
# Messages that the simulation has sent arrive within this time or never.
INPUT_WAIT_S = 0.5
# Timers take over if no map has come for this long, so that the vehicle still stops.
MISSING_MAP_S = 1.0
MAX_HELD_INPUTS = 200
MAX_WAITING_ITEMS = 8  # of one executor
ADVANCE_HZ = 20.0  # of executors, while maps are missing


def exact_time(seconds):
    """Returns a rospy.Time rounded to nanoseconds: Time.from_sec() truncates, and lock-step compares stamps exactly."""
    return rospy.Time(0, int(round(1e9 * seconds)))


class ProgressPublisher:
    """Reports to the simulator or a player, which let time pass, which inputs are done and which are about to come."""

    def __init__(self, config, node):
        """Makes the publisher of a node. config: voxnav.TimeConfig."""
        self._node, self._consumers = node, list(config.consumers) if config.waits_for_simulation else []
        self._publisher = rospy.Publisher("~progress_out", Progress, queue_size=50)

    def publish(self, stamp):
        """Reports that all inputs up to the stamp are done."""
        self._publisher.publish(Progress(node=self._node, stamp=stamp))

    def listen(self, act):
        """Calls act(stamp_s) when something is announced to this node."""
        def on_progress(msg):
            if msg.is_begun and msg.node == self._node:
                act(msg.stamp.to_sec())

        rospy.Subscriber("~progress_out", Progress, on_progress, queue_size=50)

    def announce(self, stamp):
        """Announces that a message is about to be sent to the consumers, which report this stamp when it is done."""
        for node in self._consumers:
            self._publisher.publish(Progress(node=node, stamp=stamp, is_begun=True))


class WorkTimes:
    """How long pieces of work take in simulated time, by the types of their items; drawn evenly from a seed."""

    def __init__(self, bounds_s, seed):
        """bounds_s: {type of an item: (least, greatest)} in seconds"""
        self._bounds_s, self._random = bounds_s, random.Random(seed)
        self.are_zero = not any(greatest > 0.0 for _, greatest in bounds_s.values())

    def draw_s(self, item):
        return self._random.uniform(*self._bounds_s[type(item)])


class ThreadExecutor:
    """Runs items one after another in a thread of its own; a bounded number may wait.

    run(item) does the work and returns what is to be done with its result, or None. Real work takes its own time, so
    WorkTimes have no meaning here.
    """

    def __init__(self, name, run, *_, **__):
        self._name, self._run, self._queue = name, run, queue.Queue(maxsize=MAX_WAITING_ITEMS)
        threading.Thread(target=self._loop, name=name, daemon=True).start()

    def submit(self, item):
        try:
            self._queue.put_nowait(item)
        except queue.Full:
            rospy.logerr_throttle(1.0, "%s is busy: %s dropped", self._name, type(item).__name__)

    def _loop(self):
        while not rospy.is_shutdown():
            _finish(self._run(self._queue.get()))


class InlineExecutor:
    """Runs each item at once."""

    def __init__(self, run):
        self._run = run

    def submit(self, item):
        _finish(self._run(item))


class SimulatedExecutor:
    """Runs items one after another, each of which takes simulated time.

    The work is done at the begin of that time and its result used at the end; or the work is done at the end, as with
    a command that is obeyed late. Both happen at the instants at which the simulation stands still, at the nearest one.
    """

    def __init__(self, name, run, times, seam, acts_last):
        self._name, self._run, self._times, self._seam, self._acts_last = name, run, times, seam, acts_last
        self._lock, self._waiting, self._is_advancing = threading.Lock(), collections.deque(), False
        self._due_s = self._item = self._result = None  # of the work in hand

    def submit(self, item):
        with self._lock:
            if len(self._waiting) >= MAX_WAITING_ITEMS:
                rospy.logerr_throttle(1.0, "%s is busy: %s dropped", self._name, type(item).__name__)
                return
            self._waiting.append(item)
        self.advance()

    def advance(self):
        """Begins and ends the work whose time has come."""
        with self._lock:
            if self._is_advancing:
                return  # the caller is the work itself, or another thread is at it
            self._is_advancing = True
        try:
            while self._begin() if self._item is None else self._end():
                pass
        finally:
            self._is_advancing = False

    def _begin(self):
        with self._lock:
            if not self._waiting:
                return False
            self._item = self._waiting.popleft()
        self._due_s = self._seam.now().to_sec() + self._times.draw_s(self._item)
        self._result = None if self._acts_last else self._run(self._item)
        return True

    def _end(self):
        if self._seam.now().to_sec() < self._due_s - 0.5 * SWEEP_S:
            return False
        result = self._run(self._item) if self._acts_last else self._result
        self._item = self._result = None
        _finish(result)
        return True


def _finish(result):
    if result is not None:
        result()


class RealTime:
    """Time that runs by itself. Ages and timeouts are measured by a clock that never jumps."""

    executor = ThreadExecutor

    @staticmethod
    def now():
        """Returns the time of ROS as rospy.Time."""
        return rospy.Time.now()

    @staticmethod
    def mark():
        """Returns the present time of the seam's clock, for elapsed_s()."""
        return time.monotonic()

    @staticmethod
    def elapsed_s(mark):
        return time.monotonic() - mark

    @staticmethod
    def every(rate_hz, callback):
        """Calls back at a rate for as long as the node runs."""
        rospy.Timer(rospy.Duration(1.0 / rate_hz), lambda _: callback(), reset=True)

    @staticmethod
    def deliver(_, take, *arguments):
        """Takes an input as soon as it comes."""
        take(*arguments)

    def wait_for(self, is_caught_up):
        """Sets is_caught_up(now_s): whether all inputs up to a time have come. Real time does not wait for it."""

    def arrived(self):
        """Tells that an input of is_caught_up() has come. Nothing waits for it in real time."""

    def map_arrived(self, stamp_s):
        """Tells that a local map has been taken over. Nothing waits for it in real time."""


class WaitingSimulation:
    """Simulated time that stands still after each local map until the node has reported it (lock-step).

    Something has taken long only if it did so by simulated and by wall time: time that stands still is no reason to
    give up, nor is time that runs fast.
    """

    def __init__(self, progress):
        """Makes a seam that reports to a ProgressPublisher."""
        self._progress, self._periodic, self._is_caught_up = progress, [], None
        self._held = collections.deque(maxlen=MAX_HELD_INPUTS)  # (stamp_s, take, arguments)
        self._lock, self._arrived = threading.Lock(), threading.Condition()
        self._instant_s = self._last_instant_s = None

    def executor(self, name, run, times=None, acts_last=False):
        """Returns an executor whose work takes no simulated time, or that of WorkTimes."""
        if times is None or times.are_zero:
            return InlineExecutor(run)
        executor = SimulatedExecutor(name, run, times, self, acts_last)
        self.every(ADVANCE_HZ, executor.advance)
        return executor

    def now(self):
        instant_s = self._instant_s
        return rospy.Time.now() if instant_s is None else exact_time(instant_s)

    @staticmethod
    def mark():
        return time.monotonic(), rospy.Time.now()

    @staticmethod
    def elapsed_s(mark):
        return min(time.monotonic() - mark[0], (rospy.Time.now() - mark[1]).to_sec())

    def every(self, rate_hz, callback):
        """Calls back after each map, in the order of these calls; at the rate only while maps are missing."""
        self._periodic.append(callback)
        rospy.Timer(rospy.Duration(1.0 / rate_hz), lambda _: self._is_map_missing() and callback(), reset=True)

    def deliver(self, stamp_s, take, *arguments):
        """Holds an input until the first map that is newer."""
        with self._lock:
            self._held.append((stamp_s, take, arguments))

    def wait_for(self, is_caught_up):
        self._is_caught_up = is_caught_up
        # A cloud that was lost, and with it a map, is announced instead. Then things happen without them.
        self._progress.listen(self.map_arrived)

    def arrived(self):
        with self._arrived:
            self._arrived.notify_all()

    def map_arrived(self, stamp_s):
        now_s = round(stamp_s + SWEEP_S, 6)
        if self._is_caught_up is not None:
            with self._arrived:
                self._arrived.wait_for(lambda: self._is_caught_up(now_s), INPUT_WAIT_S)
        self._release(stamp_s)
        with self._standing_at(now_s):
            for callback in self._periodic:
                callback()
        self._progress.publish(exact_time(stamp_s))

    def _release(self, before_s):
        with self._lock:
            ready = [item for item in self._held if item[0] < before_s]
            for item in ready:
                self._held.remove(item)
        for _, take, arguments in ready:
            take(*arguments)

    @contextlib.contextmanager
    def _standing_at(self, now_s):
        self._instant_s = self._last_instant_s = now_s
        try:
            yield
        finally:
            self._instant_s = None

    def _is_map_missing(self):
        if self._last_instant_s is None:
            return True
        return not 0.0 <= rospy.Time.now().to_sec() - self._last_instant_s < MISSING_MAP_S


def seam_for(config, node):
    """Returns RealTime or WaitingSimulation, as the section `time` of the node's parameters chooses.

    config: voxnav.TimeConfig; node: its name
    """
    progress = ProgressPublisher(config, node)  # on both kinds of time, so that launch files remap it on both
    return WaitingSimulation(progress) if config.waits_for_simulation else RealTime()
