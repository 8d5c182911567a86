# SPDX-License-Identifier: BSD-3-Clause
"""Refuses goals from which the vehicle would not come back on its battery, and tells when it is time to return."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from voxnav.array_types import Array
from voxnav.homing.keeper import HomeState
from voxnav.planning_manager.inputs import Limits
from voxnav.planning_manager.reasons import Because, Reason

# A goal this near to the start is the way home, which nothing refuses.
AT_HOME_M = 2.0


@dataclass(frozen=True)
class Battery:
    """The charge of the battery, 0 to 1; None: it is not measured. stamp_s: when it was told."""

    stamp_s: float
    charge: Optional[float]


@dataclass(frozen=True, eq=False)
class Trip:
    """What decides about a flight to a goal and back. Positions are in frame W."""

    goal_W: Array
    here_W: Array
    home: HomeState
    limits: Limits

    def times_s(self, detour_ratio: float) -> tuple[float, float]:
        """Returns estimates of the times to the goal and back to the start, in the straight line times detour_ratio.

        The way back is no longer than that to the goal and from here to the start, if that is known.
        """
        start_W = self.here_W if self.home.start_W is None else self.home.start_W
        there_m = detour_ratio * float(np.linalg.norm(self.goal_W - self.here_W))
        back_m = detour_ratio * float(np.linalg.norm(self.goal_W - start_W))
        if self.home.way_m is not None:
            back_m = min(back_m, there_m + self.home.way_m)
        return self._time_s(there_m), self._time_s(back_m)

    def _time_s(self, length_m: float) -> float:
        """Returns the time from rest to rest over a level way."""
        speed, acceleration = self.limits[0], self.limits[1]
        if length_m < speed ** 2 / acceleration:
            return 2.0 * float(np.sqrt(length_m / acceleration))
        return length_m / speed + speed / acceleration


def beyond_reserve(trip: Trip, battery: Optional[Battery], config: Any, now_s: float) -> Optional[Because]:
    """Tells why the battery does not hold for a goal; None if it does, or if nothing is configured.

    config: voxnav.HomeConfig
    """
    if config.full_flight_time_s <= 0.0:
        return None
    if trip.home.start_W is not None and np.linalg.norm(trip.goal_W - trip.home.start_W) < AT_HOME_M:
        return None
    unknown = _unknown_charge(battery, config, now_s)
    if unknown or battery is None or battery.charge is None:
        return Because(Reason.GOAL_BEYOND_RESERVE, ", ".join(unknown))
    there_s, back_s = trip.times_s(config.detour_ratio)
    holds_s = battery.charge * config.full_flight_time_s
    if there_s + back_s + config.reserve_s <= holds_s:
        return None
    return Because(Reason.GOAL_BEYOND_RESERVE, "goal needs %.0f s there and %.0f s back, and the battery holds %.0f s, "
                   "of which %.0f s are reserve" % (there_s, back_s, holds_s, config.reserve_s))


class Watch(enum.Enum):
    """What the battery and the way home tell in flight."""

    SILENT = 0  # nothing is configured, or nothing flies
    HOLDS = 1
    UNKNOWN = 2
    REACHED = 3


@dataclass(frozen=True)
class ReserveWatch:
    """The state of the reserve, and a sentence for people, which is empty as long as all is well."""

    watch: Watch
    sentence: str = ""


def watch_reserve(home: HomeState, battery: Optional[Battery], config: Any, now_s: float) -> ReserveWatch:
    """Tells in flight whether the battery still holds for the way home and the reserve, and what is not known of it.

    config: voxnav.HomeConfig
    """
    if config.full_flight_time_s <= 0.0 or home.start_W is None:
        return ReserveWatch(Watch.SILENT)
    unknown = [] if home.way_s is not None else ["the way home is not known"]
    unknown += _unknown_charge(battery, config, now_s)
    if unknown or battery is None or battery.charge is None or home.way_s is None:
        return ReserveWatch(Watch.UNKNOWN, "nobody tells when to return: " + ", and ".join(unknown))
    holds_s = battery.charge * config.full_flight_time_s
    if home.way_s + config.reserve_s <= holds_s:
        return ReserveWatch(Watch.HOLDS)
    return ReserveWatch(Watch.REACHED, "the way home needs %.0f s, and the battery holds %.0f s, of which %.0f s are "
                        "reserve: return now" % (home.way_s, holds_s, config.reserve_s))


def _unknown_charge(battery: Optional[Battery], config: Any, now_s: float) -> list[str]:
    """Tells why the charge of the battery is not known, in one phrase; none if it is known."""
    if battery is not None and battery.charge is None:
        return ["the charge of the battery is not measured"]
    if battery is None or now_s - battery.stamp_s > config.battery_timeout_s:
        return ["the charge of the battery is not known"]
    return []
