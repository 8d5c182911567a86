# SPDX-License-Identifier: BSD-3-Clause
"""The start and the diagnostics of all rospy nodes of voxnav."""

import contextlib
import sys
import threading
import time

import rospy

import voxnav
from voxnav.msg import NodeDiagnostics, StageSummary


class Diagnostics:
    """Collects the diagnostics of a node, and publishes them once a second of wall time. Thread-safe."""

    def __init__(self, node):
        self._node = node
        self._lock = threading.Lock()
        self._stages = {}
        self._counters = {}
        self._level, self._message = NodeDiagnostics.OK, ""
        self._publisher = rospy.Publisher("~diagnostics_out", NodeDiagnostics, queue_size=2, latch=True)
        # Diagnostics run on wall time, so that they are published even while the simulated clock stands still.
        self._stop = threading.Event()
        rospy.on_shutdown(self._stop.set)
        threading.Thread(target=self._run, name="diagnostics", daemon=True).start()

    @contextlib.contextmanager
    def time(self, stage):
        """Measures a `with` block, whose wall and CPU time in the calling thread is added to a stage."""
        wall, cpu = time.monotonic(), time.thread_time()
        try:
            yield
        finally:
            wall_ms, cpu_ms = 1e3 * (time.monotonic() - wall), 1e3 * (time.thread_time() - cpu)
            with self._lock:
                self._stage(stage).add(wall_ms, cpu_ms)

    def add_dropped(self, stage, count=1):
        with self._lock:
            self._stage(stage).dropped += count

    def set_counter(self, name, value):
        with self._lock:
            self._counters[name] = float(value)

    def set_level(self, level, message=""):
        with self._lock:
            self._level, self._message = level, message

    def _stage(self, name):
        return self._stages.setdefault(name, voxnav.StageStatistics())

    def _run(self):
        while not self._stop.wait(1.0):
            try:
                self._publisher.publish(self._message_now())
            except rospy.ROSException:
                return  # the node is going down

    def _message_now(self):
        usage = voxnav.process_usage()
        out = NodeDiagnostics(node=self._node, rss_bytes=usage["rss_bytes"], cpu_s=usage["cpu_s"])
        out.header.stamp = rospy.Time.now()
        with self._lock:
            out.level, out.message = self._level, self._message
            out.counter_names, out.counter_values = list(self._counters), list(self._counters.values())
            for name, stage in self._stages.items():
                numbers = stage.summary()
                numbers.pop("median_ms")
                out.stages.append(StageSummary(name=name, **numbers))
        return out


def run_node(name, make_node):
    """Starts a node. Bad parameters end it with a list of every problem instead of a traceback."""
    rospy.init_node(name)
    try:
        node = make_node()  # kept alive until shutdown
    except voxnav.ConfigError as error:
        rospy.logfatal("[%s]: not started:\n%s", name, error)
        sys.exit(1)
    rospy.loginfo("[%s]: initialized", name)
    rospy.spin()
    return node
