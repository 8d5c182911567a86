# SPDX-License-Identifier: BSD-3-Clause
"""The inputs of the planning manager from the vehicle and the maps."""

import enum
from dataclasses import dataclass, field
from typing import FrozenSet, Generic, Optional, Sequence, Tuple, TypeVar

import numpy as np

from voxnav.array_types import Array
from voxnav.fences.placing import PlacedFences

T = TypeVar("T")
# Limits of speed [m/s] and acceleration [m/s^2] outside this range are no limits of a UAV.
LEAST_LIMIT, GREATEST_LIMIT = 0.05, 100.0
# A vehicle that is this far from where its velocity leads it within this time has not moved there.
JUMP_M, JUMP_TIME_S = 1.0, 0.5
# Speed and acceleration, each horizontal, ascending and descending, in pairs [m/s, m/s^2].
Limits = Tuple[float, float, float, float, float, float]


@dataclass(frozen=True, eq=False)
class Timed(Generic[T]):
    """A value and the time at which it was true [s]."""

    stamp_s: float
    value: T


@dataclass(frozen=True, eq=False)
class Vehicle:
    position_O: Array
    velocity_O: Array

    @property
    def speed_mps(self) -> float:
        return float(np.linalg.norm(self.velocity_O))


def jump_m(before: Optional[Timed[Vehicle]], now: Timed[Vehicle]) -> float:
    """Returns how far a vehicle has jumped between two messages; zero if it can have flown there, or in long gaps."""
    if before is None or not 0.0 < now.stamp_s - before.stamp_s <= JUMP_TIME_S:
        return 0.0
    velocity = 0.5 * (before.value.velocity_O + now.value.velocity_O)
    flown = velocity * (now.stamp_s - before.stamp_s)
    gap_m = float(np.linalg.norm(now.value.position_O - before.value.position_O - flown))
    return gap_m if gap_m > JUMP_M else 0.0


@dataclass(frozen=True, eq=False)
class Prediction:
    """The tracker's prediction: rising times [s] and positions (n, 3) in O, both finite.

    input_id: the number that whoever asked for the tracker's last trajectory gave it; None: the tracker does not tell
    """

    times_s: Array
    positions_O: Array
    input_id: Optional[int] = None

    @property
    def is_usable(self) -> bool:
        """Returns False for arrays that are no prediction."""
        is_fitting = self.times_s.ndim == 1 and self.positions_O.shape == (len(self.times_s), 3)
        return bool(is_fitting and len(self.times_s) > 0 and np.isfinite(self.times_s).all()
                    and np.isfinite(self.positions_O).all() and (np.diff(self.times_s) > 0.0).all())

    @property
    def across_m(self) -> float:
        """The horizontal distance from the first to the last position."""
        way = self.positions_O[-1] - self.positions_O[0]
        return float(np.hypot(way[0], way[1]))

    def at(self, time_s: float) -> Optional[Array]:
        """Returns the position at a time; None outside the predicted time."""
        if not self.times_s[0] <= time_s <= self.times_s[-1]:
            return None
        return np.array([np.interp(time_s, self.times_s, self.positions_O[:, axis]) for axis in range(3)])


class TrackerState(enum.Enum):
    """What the active tracker is doing. The values are those of mrs_msgs/TrackerStatus."""

    INVALID = 0
    IDLE = 1
    TAKE_OFF = 2
    HOVER = 3
    REFERENCE = 4
    TRAJECTORY = 5
    LAND = 6


# States of a tracker that holds the vehicle in the air, or brings it down.
IN_AIR = (TrackerState.HOVER, TrackerState.REFERENCE, TrackerState.TRAJECTORY, TrackerState.LAND)


@dataclass(frozen=True)
class Control:
    """The diagnostics of the control manager and its tracker."""

    # False during take-off and landing, under remote control, in an emergency, while the bumper repels the vehicle, and
    # after the callbacks of the control manager were disabled.
    is_flying: bool
    accepts_goals: bool  # callbacks are enabled; MRS takes them away while the tracker brakes to hover
    is_tracking: bool  # the tracker follows a trajectory
    is_repelling: bool = False  # the bumper of the control manager moves the vehicle away from something
    is_remote: bool = False  # a pilot flies the vehicle by remote control
    has_output: bool = True  # the control manager commands the vehicle at all
    has_goal: bool = False  # the tracker moves to a reference, or follows a trajectory
    state: TrackerState = TrackerState.INVALID
    tracker: str = ""  # names of the active tracker and controller, for people
    controller: str = ""

    @property
    def is_free(self) -> bool:
        return self.is_flying and self.accepts_goals

    @property
    def is_on_ground(self) -> bool:
        """True if nobody flies the vehicle. The control manager reports flight by others as not flying normally."""
        is_held = self.has_output and self.state in IN_AIR
        return not (self.is_flying or self.is_repelling or self.is_remote or is_held)


@dataclass(frozen=True)
class Frames:
    """Frames of the local map, of the odometry, and of the map correction T_W_O; None until they are known."""

    map: Optional[str] = None
    odometry: Optional[str] = None
    correction: Optional[str] = None

    @property
    def differ(self) -> bool:
        """True if places on the maps are not those of the vehicle: nothing can be checked or planned then."""
        known = {frame for frame in (self.map, self.odometry, self.correction) if frame is not None}
        return len(known) > 1


@dataclass(frozen=True, eq=False)
class Fencing:
    """The fences in frame O. placed: None if there are none; problem: why they are not known, '' if they are."""

    placed: Optional[PlacedFences] = None
    problem: str = ""


@dataclass(frozen=True, eq=False)
class Inputs:
    """The newest value of every input; None until the first one has come."""

    vehicle: Optional[Timed[Vehicle]] = None
    prediction: Optional[Timed[Prediction]] = None
    control: Optional[Timed[Control]] = None
    limits: Optional[Timed[Limits]] = None  # the newest usable ones, by which the vehicle brakes
    limits_problem: str = ""  # why the newest ones cannot be used; '' if they can
    T_W_O: Optional[Timed[Array]] = None
    map_stamp_s: Optional[float] = None
    frames: Frames = Frames()
    lost_nodes: FrozenSet[str] = field(default_factory=frozenset)
    fencing: Fencing = Fencing()
    others_problem: str = ""  # why it is not known where other UAVs are; '' if it is, or if there are none

    @property
    def is_on_ground(self) -> bool:
        """True if the vehicle is known not to fly."""
        return self.control is not None and self.control.value.is_on_ground

    @property
    def is_in_air(self) -> bool:
        """True if the vehicle is known to fly, whoever flies it."""
        return self.control is not None and not self.control.value.is_on_ground


def problem_of_limits(values: Sequence[float]) -> str:
    """Tells why limits are no limits of a UAV; '' if they may be."""
    if not np.isfinite(values).all():
        return "constraints are not finite"
    if not (LEAST_LIMIT <= min(values) and max(values) <= GREATEST_LIMIT):
        return "constraints are not between %g and %g" % (LEAST_LIMIT, GREATEST_LIMIT)
    return ""
