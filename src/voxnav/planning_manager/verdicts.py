# SPDX-License-Identifier: BSD-3-Clause
"""What a search tells about the goal: one reason for each status, and when it is decided that the goal is given up.

A status about the goal itself (blocked, enclosed) is told while the vehicle flies to the nearest place that the search
found, and decided once it is there. Nobody wants to go near a goal below the ground or beyond a fence, which is
decided at once. Other
statuses that nothing but a changed map would change are decided once they have persisted for confirm_s, while nothing
that leads nearer to the goal can be flown. So one and the same goal in one and the same map gets the same answer each
time.
"""

from dataclasses import dataclass, replace
from typing import Optional

from voxnav._core import PlanOutcome, PlanStatus, explain
from voxnav.planning_manager.reasons import Because, Reason

# Where nothing is flown, a status about the goal is confirmed by a second search, because of single wrong voxels.
SECOND_SEARCH_S = 0.4


@dataclass(frozen=True)
class Meaning:
    """What a status of a search means for the goal.

    is_about_goal: it holds from wherever the goal is flown to; leads_near: there is a place near the goal that is worth
    flying to; confirm_s: how long other statuses must persist until the goal is given up, None if they do not decide it
    """

    reason: Reason
    is_about_goal: bool = False
    leads_near: bool = True
    confirm_s: Optional[float] = None


MEANINGS = {
    PlanStatus.COMPLETE: Meaning(Reason.MOVING),
    PlanStatus.PARTIAL_TIMEOUT: Meaning(Reason.SEARCH_ENDED),
    PlanStatus.PARTIAL_LIMIT: Meaning(Reason.SEARCH_ENDED),
    PlanStatus.PARTIAL_BLOCKED: Meaning(Reason.NO_WAY, confirm_s=3.0),
    PlanStatus.NO_PATH: Meaning(Reason.NO_WAY, confirm_s=3.0),
    PlanStatus.START_BLOCKED: Meaning(Reason.PLAN_FAILED),
    PlanStatus.START_UNKNOWN: Meaning(Reason.PLAN_FAILED),
    PlanStatus.GOAL_BLOCKED: Meaning(Reason.GOAL_BLOCKED, is_about_goal=True),
    PlanStatus.GOAL_UNKNOWN: Meaning(Reason.GOAL_UNSEEN, confirm_s=3.0),
    PlanStatus.GOAL_ENCLOSED: Meaning(Reason.GOAL_ENCLOSED, is_about_goal=True),
    PlanStatus.GOAL_BELOW_GROUND: Meaning(Reason.GOAL_BELOW_GROUND, is_about_goal=True, leads_near=False),
    PlanStatus.OUTSIDE_MAP: Meaning(Reason.GOAL_OUTSIDE_MAP),
    PlanStatus.START_FENCED: Meaning(Reason.FENCED),
    PlanStatus.GOAL_FENCED: Meaning(Reason.GOAL_FENCED, is_about_goal=True, leads_near=False),
    PlanStatus.INVALID_INPUT: Meaning(Reason.PLAN_FAILED),
}


@dataclass(frozen=True)
class Verdict:
    """A reason against the goal, and since when all searches have given it and nothing was worth flying.

    confirm_s: how long that must be so until the goal is given up; None: it is only told when the goal is given up
    """

    because: Because
    since_s: float
    confirm_s: Optional[float]

    def is_final(self, now_s: float) -> bool:
        return self.confirm_s is not None and now_s - self.since_s >= self.confirm_s


def verdict_of(before: Optional[Verdict], outcome: PlanOutcome, is_resting: bool, now_s: float) -> Optional[Verdict]:
    """Returns the verdict after a search that found nothing worth flying; None if that tells nothing about the goal.

    before: the verdict of the searches before; is_resting: the vehicle rests, and the path leads nowhere else
    """
    meaning = MEANINGS[outcome.status]
    has_path = meaning.leads_near and len(outcome.plan.path) > 0
    confirm_s = meaning.confirm_s if is_resting else None
    if meaning.is_about_goal:
        confirm_s = SECOND_SEARCH_S if not has_path else 0.0 if is_resting else None
    elif confirm_s is None:
        return None
    if before is not None and before.because.reason is meaning.reason:
        return replace(before, confirm_s=confirm_s)
    because = Because(meaning.reason, "goal cannot be reached: " + explain(outcome.status))
    return Verdict(because, now_s, confirm_s)
