# SPDX-License-Identifier: BSD-3-Clause
"""The rule by which a goal is given up that the vehicle does not come nearer to.

Progress is a way left to the goal that is shorter than the shortest one so far, by at least PROGRESS_M. The way left is
that of the newest plan: its path, and the straight line from its end if it does not reach the goal. It is not the
distance that was moved, so wandering is no progress. When a new plan is longer than the shortest way by more than
DEAD_END_M, the way turned out to be closed: that counts as a dead end, and the rule begins anew with the new way,
because a detour leads away from the goal at first. The goal is given up after stuck_time_s without progress, or after
max_dead_ends dead ends.
"""

from dataclasses import dataclass, replace
from typing import Any, Optional

# Ways that are shorter by less than this are no progress; ways that are longer by more than this are detours.
PROGRESS_M, DEAD_END_M = 1.0, 5.0


@dataclass(frozen=True)
class GoalProgress:
    """The shortest way left to the goal, None before the first plan; since_s: when it was found, or the goal set."""

    since_s: float
    shortest_m: Optional[float] = None
    num_dead_ends: int = 0

    def after(self, left_m: float, now_s: float) -> "GoalProgress":
        """Returns the progress when this way is left on the flown trajectory."""
        if self.shortest_m is not None and left_m > self.shortest_m - PROGRESS_M:
            return self
        return replace(self, since_s=now_s, shortest_m=left_m)

    def after_plan(self, left_m: float, now_s: float) -> "GoalProgress":
        """Returns the progress when a new plan leaves this way."""
        if self.shortest_m is None or left_m <= self.shortest_m + DEAD_END_M:
            return self.after(left_m, now_s)
        return GoalProgress(now_s, left_m, self.num_dead_ends + 1)

    def problem(self, now_s: float, config: Any) -> str:
        """Tells why the goal is given up; '' if it is not. config: voxnav.PlanningManagerConfig"""
        if self.num_dead_ends >= config.max_dead_ends:
            return "%d ways were closed" % self.num_dead_ends
        if now_s - self.since_s > config.stuck_time_s:
            return "no shorter way for %.0f s" % config.stuck_time_s
        return ""
