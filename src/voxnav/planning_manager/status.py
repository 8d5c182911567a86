# SPDX-License-Identifier: BSD-3-Clause
"""The status of the planning manager, for messages and logs."""

from dataclasses import dataclass
from typing import Any, Optional

from voxnav.array_types import Array
from voxnav.planning_manager.reasons import Because, Reason


@dataclass
class Status:
    """The fields of the message PlannerStatus, which can also be read as status["name"]."""

    state: int = 0
    because: Because = Because(Reason.NO_GOAL, "no goal")
    goal_W: Optional[Array] = None
    refusal: Optional[Because] = None  # why the last goal that was set was refused
    is_goal_reached: bool = False  # whether the last goal was reached
    plan_status: str = ""  # status of the last search
    expansions: int = 0
    plan_s: float = 0.0
    num_plans: int = 0
    num_trajectories: int = 0
    num_shortened: int = 0
    num_hovers: int = 0

    @property
    def reason(self) -> str:
        return self.because.sentence

    def note_search(self, plan: Any) -> None:
        """plan: voxnav.PlanResult"""
        self.plan_status, self.expansions, self.plan_s = plan.status, plan.expansions, plan.seconds

    def __getitem__(self, name: str) -> Any:
        return getattr(self, name)
