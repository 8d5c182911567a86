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

    def announce(self, stamp):
        """Announces that a message is about to be sent to the consumers, which report this stamp when it is done."""
        for node in self._consumers:
            self._publisher.publish(Progress(node=node, stamp=stamp, is_begun=True))


class ThreadExecutor:
    """Runs items one after another in a thread of its own; a bounded number may wait."""

    def __init__(self, name, run):
        self._name, self._run, self._queue = name, run, queue.Queue(maxsize=8)
        threading.Thread(target=self._loop, name=name, daemon=True).start()

    def submit(self, item):
        try:
            self._queue.put_nowait(item)
        except queue.Full:
            rospy.logerr_throttle(1.0, "%s is busy: %s dropped", self._name, type(item).__name__)

    def _loop(self):
        while not rospy.is_shutdown():
            self._run(self._queue.get())


class InlineExecutor:
    """Runs each item at once."""

    def __init__(self, _, run):
        self.submit = run


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

    executor = InlineExecutor

    def __init__(self, progress):
        """Makes a seam that reports to a ProgressPublisher."""
        self._progress, self._periodic, self._is_caught_up = progress, [], None
        self._held = collections.deque(maxlen=MAX_HELD_INPUTS)  # (stamp_s, take, arguments)
        self._lock, self._arrived = threading.Lock(), threading.Condition()
        self._instant_s = self._last_instant_s = None

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
