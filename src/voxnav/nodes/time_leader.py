# SPDX-License-Identifier: BSD-3-Clause
"""Decides how far simulated time may run, so that commands come at instants that do not depend on the machine."""

import time

import rospy
from voxnav.msg import Progress
from voxnav.nodes.time_seam import exact_time

# The stamps at which the leader stops time are multiples of this: ends of sweeps at 10 and 20 Hz.
STEP_S = 0.1
# This is longer than the simulator waits for a silent node (lockstep_timeout_s), so that it can report which one.
ANSWER_LIMIT_S = 120.0


class TimeLeader:
    """The leader of a lock-step simulation: time stands still before release() but for the calls of run_for().

    name: the value of the simulator's parameter lockstep_leader.
    """

    def __init__(self, name):
        self._name, self._horizon_s, self.is_leading = name, None, True
        self._publisher = rospy.Publisher("progress", Progress, queue_size=10)

    def run_for(self, duration_s):
        """Lets time run, and returns the instant at which it stands still again. Raises TimeoutError."""
        if self._horizon_s is None:
            self._wait(lambda: self._publisher.get_num_connections() > 0, "the simulator to listen")
            self._horizon_s = rospy.Time.now().to_sec()
        self._horizon_s = round(round((self._horizon_s + duration_s) / STEP_S) * STEP_S, 6)
        self._publisher.publish(Progress(node=self._name, stamp=exact_time(self._horizon_s)))
        self._wait(lambda: rospy.Time.now().to_sec() > self._horizon_s - 1e-4, "simulated time to go on")
        return self._horizon_s

    @property
    def now_s(self):
        """Returns the instant at which time stands still."""
        return self._horizon_s

    def release(self):
        """Lets time run on by itself from here."""
        self.is_leading = False
        self._publisher.publish(Progress(node=self._name, stamp=rospy.Time(4000000000)))

    @staticmethod
    def _wait(condition, what):
        deadline = time.monotonic() + ANSWER_LIMIT_S
        while not condition():
            if time.monotonic() > deadline or rospy.is_shutdown():
                raise TimeoutError("waited in vain for " + what)
            time.sleep(0.002)
