# SPDX-License-Identifier: BSD-3-Clause
"""The three states and what each of them holds. All are values: a transition makes new ones."""

from dataclasses import dataclass
from typing import Optional, Union

import numpy as np

from voxnav._core import PlanOutcome, Trajectory
from voxnav.array_types import Array
from voxnav.planning_manager.actions import Means
from voxnav.planning_manager.progress import GoalProgress
from voxnav.planning_manager.reasons import Because
from voxnav.planning_manager.verdicts import Verdict

# The vehicle is searched on the trajectory within this time before and after its scheduled time.
BEHIND_S, AHEAD_S = 1.5, 0.5
# Tracking lags behind: the vehicle comes to rest this much after the end of the trajectory.
SETTLING_S = 0.5


@dataclass(frozen=True, eq=False)
class Goal:
    position_W: Array
    heading_rad: Optional[float]  # frame W; None: any
    has_been_free: bool = False  # the vehicle was free to fly to it; when that ends, it was taken over


@dataclass(frozen=True)
class OwnHover:
    """A stop that voxnav asked for. It is repeated until the control manager accepts it; then the tracker brakes."""

    because: Because
    sent_s: float
    accepted_s: Optional[float] = None
    means: Means = Means.HOVER
    failed: str = ""  # which means was refused last, and why
    is_second_choice: bool = False  # another means was accepted before, but its way turned out not to be free


@dataclass(frozen=True, eq=False)
class Leads:
    """The end of a trajectory: its distance from the goal and its corridor."""

    radius_m: float  # known free around it
    is_to_goal: bool
    left_m: Optional[float]  # distance from its end to the goal; None: unknown, any plan is better
    is_last: bool = False  # it ends at the goal, or at the nearest place to a blocked one: no plan leads nearer


@dataclass(frozen=True, eq=False)
class Flight:
    """A trajectory that the tracker has accepted."""

    trajectory: Trajectory
    begin_s: float  # time of its first point
    leads: Leads
    goal_O: Array  # position of the goal in O when this was planned
    asked_s: float  # time at which the tracker was asked; the flight began no earlier
    taken_s: float  # time of its answer; later predictions show the flight
    is_tracked: bool = False  # the tracker has been seen to fly it
    left_s: Optional[float] = None  # since when the vehicle or its prediction has been off it; None: it is on it

    def is_flown(self, now_s: float) -> bool:
        return now_s < self.begin_s + float(self.trajectory.duration_s) + SETTLING_S

    def arc_m(self, position_O: Array, now_s: float) -> float:
        """Returns the arc length at which the vehicle is."""
        t = now_s - self.begin_s
        return float(self.trajectory.project(position_O, t - BEHIND_S, t + AHEAD_S))

    def deviation_m(self, position_O: Array, time_s: float) -> float:
        """Returns the distance of a position, past or predicted, from where the trajectory is at about that time."""
        nearest_O = self.trajectory.points_from_arc(self.arc_m(position_O, time_s))[0]
        return float(np.linalg.norm(position_O - nearest_O))


@dataclass(frozen=True)
class Searching:
    job: int
    begin_s: float
    start_stamp_s: Optional[float]  # when the vehicle will be at the start; None: it rests there


@dataclass(frozen=True, eq=False)
class Generating:
    job: int
    begin_s: float
    outcome: PlanOutcome


@dataclass(frozen=True, eq=False)
class Publishing:
    job: int
    begin_s: float
    trajectory: Trajectory
    stamp_s: Optional[float]  # time of its first point; None: the tracker begins when it takes it
    leads: Leads
    because: Because  # reason of the state once the trajectory is flown
    is_shortening: bool


Job = Union[Searching, Generating, Publishing]


@dataclass(frozen=True, eq=False)
class Idle:
    """Nothing is flown: there is no goal, or something that a flight needs is missing."""

    because: Because
    goal: Optional[Goal] = None  # a kept goal: the flight resumes once nothing is missing any more
    hover: Optional[OwnHover] = None
    danger: Optional[Because] = None  # what is wrong with the way on which somebody else flies the vehicle
    late_s: Optional[float] = None  # when the tracker answered that it took a trajectory that nobody wants any more


@dataclass(frozen=True, eq=False)
class Planning:
    """There is a goal and no trajectory to it, or one that had to be shortened or led to another goal."""

    because: Because
    goal: Goal
    plan_from_s: float  # no search begins earlier
    job: Optional[Job] = None
    flight: Optional[Flight] = None
    progress: Optional[GoalProgress] = None
    hover: Optional[OwnHover] = None
    verdict: Optional[Verdict] = None
    goal_state: Optional[int] = None  # what the map knew of the goal's place when it was last planned to


@dataclass(frozen=True, eq=False)
class Moving:
    """A trajectory towards the goal is flown, and perhaps the next one prepared."""

    because: Because
    goal: Goal
    flight: Flight
    plan_from_s: float
    job: Optional[Job] = None
    progress: Optional[GoalProgress] = None
    verdict: Optional[Verdict] = None
    goal_state: Optional[int] = None


Active = Union[Planning, Moving]
State = Union[Idle, Planning, Moving]


def own_hover(state: State) -> Optional[OwnHover]:
    """Returns the stop that voxnav asked for and that is not over yet."""
    return None if isinstance(state, Moving) else state.hover


def flight_of(state: State) -> Optional[Flight]:
    return None if isinstance(state, Idle) else state.flight
