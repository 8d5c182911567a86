# SPDX-License-Identifier: BSD-3-Clause
"""The actions that the planning manager requests. The node answers each one by the call that its docstring names."""

import enum
from dataclasses import dataclass
from typing import ClassVar, Optional, Union

from voxnav._core import Trajectory
from voxnav.array_types import Array
from voxnav.planning_manager.reasons import Because


class Means(enum.Enum):
    """How the vehicle is stopped. The value is what is said about it."""

    HOVER = "hover"  # the control manager brakes straight ahead
    FOLLOW = "braking along the trajectory"
    CLIMB = "climbing"
    EHOVER = "emergency hover"  # after it the control manager refuses all commands until a person allows them again


@dataclass(frozen=True, eq=False)
class Plan:
    """Search a path with voxnav.run_plan_job; answered by plan_done."""

    name: ClassVar[str] = "plan"
    job: int
    start_O: Array
    goal_O: Array


@dataclass(frozen=True, eq=False)
class Generate:
    """Ask the generator for a trajectory; answered by generate_done."""

    name: ClassVar[str] = "generate"
    job: int
    waypoints_O: Array
    start_stamp_s: Optional[float]  # time at which the vehicle will be at the first waypoint; None: it rests there
    heading_rad: Optional[float]  # heading at the last waypoint, frame O; None: any


@dataclass(frozen=True, eq=False)
class Publish:
    """Hand a trajectory to the tracker, to be flown at once; answered by publish_done."""

    name: ClassVar[str] = "publish"
    job: int
    trajectory: Trajectory
    stamp_s: Optional[float]  # time of its first point; the tracker skips what is over; None: the time of publishing
    because: Because
    is_shortening: bool


@dataclass(frozen=True, eq=False)
class Hover:
    """Stop now; answered by hover_done. It must not wait behind a search, a generator or another trajectory."""

    name: ClassVar[str] = "hover"
    because: Because
    is_repeat: bool = False
    means: Means = Means.HOVER
    trajectory: Optional[Trajectory] = None  # the trajectory to rest for FOLLOW and CLIMB, to be flown at once


Action = Union[Plan, Generate, Publish, Hover]
Job = Union[Plan, Generate, Publish]
