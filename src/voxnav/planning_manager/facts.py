# SPDX-License-Identifier: BSD-3-Clause
"""The arguments of a transition beside the state: the time, the inputs, the configuration."""

import math
from dataclasses import dataclass, replace
from typing import Any, Callable, Optional, Tuple, TypeVar

import numpy as np

from voxnav.array_types import Array
from voxnav.planning_manager.actions import Action
from voxnav.planning_manager.inputs import Control, Inputs, Limits, Timed, Vehicle
from voxnav.planning_manager.missing import missing
from voxnav.planning_manager.reasons import Because
from voxnav.planning_manager.states import Flight, Goal, State

T = TypeVar("T")
Step = Tuple[State, Tuple[Action, ...]]
# The map correction may move the goal this far in O before a path to it is planned again.
GOAL_SHIFT_M = 0.3


@dataclass(frozen=True, eq=False)
class Facts:
    """The arguments of a transition. job: number for a job that begins now.

    look returns the newest map as voxnav.OccupancyView, or None if there is none to check against. Reading an input
    that is missing raises LookupError.
    """

    now_s: float
    inputs: Inputs
    config: Any  # voxnav.PlanningManagerConfig
    job: int
    look: Callable[[], Any]

    @property
    def vehicle(self) -> Vehicle:
        return _there(self.inputs.vehicle)

    @property
    def limits(self) -> Limits:
        return _there(self.inputs.limits)

    @property
    def is_vehicle_known(self) -> bool:
        """Returns True if the vehicle's place and what it may do are known, and recent."""
        vehicle, limits = self.inputs.vehicle, self.inputs.limits
        if vehicle is None or limits is None:
            return False
        return bool(self.now_s - vehicle.stamp_s <= self.config.odometry_timeout_s)

    @property
    def is_in_motion(self) -> bool:
        return bool(self.vehicle.speed_mps > self.config.rest_speed_mps)

    @property
    def control(self) -> Optional[Timed[Control]]:
        """The diagnostics of the control manager; None if there are none, or only old ones."""
        control = self.inputs.control
        if control is None or self.now_s - control.stamp_s > self.config.diagnostics_timeout_s:
            return None
        return control

    def blind(self) -> "Facts":
        """Returns these facts without a map, for when the map is in another frame than the vehicle."""
        return replace(self, look=_no_map)

    def missing(self) -> Optional[Because]:
        return missing(self.inputs, self.now_s, self.config)

    def goal_O(self, goal: Goal) -> Array:
        T_W_O = _there(self.inputs.T_W_O)
        return np.asarray(T_W_O[:3, :3].T.dot(goal.position_W - T_W_O[:3, 3]))

    def heading_O(self, goal: Goal) -> Optional[float]:
        if goal.heading_rad is None:
            return None
        T_W_O = _there(self.inputs.T_W_O)
        return math.remainder(goal.heading_rad - math.atan2(T_W_O[1, 0], T_W_O[0, 0]), 2.0 * math.pi)

    def predicted(self, time_s: float) -> Optional[Array]:
        """Returns the position that the tracker predicts; None beyond the time that it predicts."""
        prediction = self.inputs.prediction
        return None if prediction is None else prediction.value.at(time_s)

    def flown(self, flight: Optional[Flight]) -> Optional[Flight]:
        """Returns the flight if the vehicle is still in motion along it, else None."""
        return flight if flight is not None and flight.is_flown(self.now_s) else None

    def goal_state(self, goal: Goal) -> Optional[int]:
        """Returns the state of the goal's voxel as voxnav.OccupancyView.states does; None without a map."""
        view = self.look()
        if view is None:
            return None
        return int(view.states(np.asarray(self.goal_O(goal), dtype=np.float32).reshape(1, 3))[0])

    def next_plan_s(self, flight: Flight) -> float:
        """Returns the time at which to plan again: so early that a new trajectory is there before this one brakes."""
        config = self.config
        braking_s = flight.begin_s + float(flight.trajectory.braking_begins_s)
        before_s = braking_s - config.planning_budget_s - config.generation_budget_s
        soonest_s = self.now_s + min(config.retry_interval_s, config.replan_interval_s)
        return float(min(max(soonest_s, before_s), self.now_s + config.replan_interval_s))

    def has_goal_moved(self, flight: Flight, goal: Goal) -> bool:
        """Returns True if the map correction has moved the goal so far that the trajectory no longer leads to it."""
        return bool(np.linalg.norm(flight.goal_O - self.goal_O(goal)) > GOAL_SHIFT_M)


def _there(timed: Optional[Timed[T]]) -> T:
    if timed is None:
        raise LookupError("an input that a transition needs has not come yet")
    return timed.value


def _no_map() -> None:
    return None
