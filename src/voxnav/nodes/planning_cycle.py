# SPDX-License-Identifier: BSD-3-Clause
"""Which time the planning manager works at: the clock's, or in lock-step that of the map it was given."""

import contextlib

import rospy

# In lock-step a timer steps in when no map has come for this long, so that the vehicle still stops.
MISSING_MAP_S = 1.0


def exact_time(seconds):
    """rospy.Time, rounded to the nanosecond: Time.from_sec() cuts off, and lock-step compares stamps exactly."""
    return rospy.Time(0, int(round(1e9 * seconds)))


class CycleClock:
    """now() is the ROS clock; while a cycle runs, the instant at which simulated time stands still for it.

    lag_s: how long after the stamp of its map that is.
    """

    def __init__(self, lag_s):
        self._lag_s, self._cycle_s, self._last_s = lag_s, None, -1e18

    def now(self):
        return rospy.Time.now() if self._cycle_s is None else exact_time(self._cycle_s)

    def instant_of(self, map_stamp_s):
        return round(map_stamp_s + self._lag_s, 6)

    @contextlib.contextmanager
    def cycle(self, map_stamp_s):
        self._cycle_s = self._last_s = self.instant_of(map_stamp_s)
        try:
            yield self._cycle_s
        finally:
            self._cycle_s = None

    def is_map_missing(self):
        return not 0.0 <= rospy.Time.now().to_sec() - self._last_s < MISSING_MAP_S
