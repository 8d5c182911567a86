# SPDX-License-Identifier: BSD-3-Clause
"""Reasons for the state of the planning manager: an enum for decisions, and a sentence for people."""

import enum
from dataclasses import dataclass


class Level(enum.Enum):
    """The level at which a reason is shown in the diagnostics."""

    OK = 0
    WARN = 1


class Reason(enum.Enum):
    """Every reason for a state. The value is its name in logs; level is its severity."""

    NO_GOAL = "no goal"
    NEW_GOAL = "new goal"
    RESUMED = "flight resumes"
    STOPPED = "stopped"
    REACHED = "goal reached"
    GOAL_BLOCKED = "goal blocked"
    GOAL_ENCLOSED = "goal enclosed"
    GOAL_UNSEEN = "goal cannot be seen"
    GOAL_BELOW_GROUND = "goal below the ground"
    GOAL_OUTSIDE_MAP = "goal outside the map"
    GOAL_OUTSIDE_AREA = "goal outside the safety area"
    GOAL_IN_ZONE = "goal in a no-fly zone"
    GOAL_FENCED = "goal fenced off"
    GOAL_BEYOND_RESERVE = "goal beyond the battery's reserve"
    GOAL_REFUSED = "goal refused by the control manager"
    STUCK = "stuck"
    TAKEN_OVER = "taken over"
    SAFETY_AREA = "outside the safety area"
    MAP_CLOSED = "map closed"
    MOVING = "moving"
    SEARCH_ENDED = "search ended by a limit"
    NO_WAY = "no way to the goal"
    PLAN_FAILED = "no plan"
    GENERATOR_FAILED = "no trajectory"
    TRAJECTORY_REFUSED = "trajectory refused"
    NO_ANSWER = "no answer"
    SHORTENED = "shortened"
    BRAKE = "brake"
    DEVIATED = "deviates from the trajectory"
    UNSAFE_PREDICTION = "the tracker leads elsewhere"
    OTHERS_UNSAFE = "somebody else flies where it is not known to be free"
    FRAME_JUMPED = "frame jumped"
    CLOCK_JUMPED = "clock jumped"
    NO_ODOMETRY = "no odometry"
    NO_DIAGNOSTICS = "no diagnostics"
    NOT_FLYING = "not flying"
    REPELLED = "repelled by the bumper"
    REMOTE_CONTROL = "flown by remote control"
    LANDING = "landing"
    NOT_NORMAL = "not flown normally"
    TRACKER_REFUSES = "tracker does not accept goals"
    NO_CONSTRAINTS = "no constraints"
    NO_PREDICTION = "no prediction"
    NO_MAP = "no map"
    FRAMES_DIFFER = "frames differ"
    NO_CORRECTION = "no correction"
    NODE_LOST = "node lost"
    OTHERS_UNPLACED = "where other UAVs are is not known"
    FENCES_UNKNOWN = "fences not known"
    FENCED = "vehicle outside its fences"

    @property
    def level(self) -> Level:
        """WARN for everything that keeps the vehicle from flying to its goal."""
        return Level.OK if self in _USUAL else Level.WARN


_USUAL = frozenset((
    Reason.NO_GOAL, Reason.NEW_GOAL, Reason.RESUMED, Reason.STOPPED, Reason.REACHED, Reason.GOAL_BLOCKED,
    Reason.GOAL_ENCLOSED, Reason.GOAL_UNSEEN, Reason.GOAL_BELOW_GROUND, Reason.GOAL_OUTSIDE_MAP,
    Reason.GOAL_OUTSIDE_AREA, Reason.GOAL_IN_ZONE, Reason.GOAL_FENCED, Reason.GOAL_BEYOND_RESERVE, Reason.GOAL_REFUSED,
    Reason.MOVING, Reason.SEARCH_ENDED, Reason.NO_WAY, Reason.PLAN_FAILED, Reason.GENERATOR_FAILED,
    Reason.TRAJECTORY_REFUSED, Reason.NO_ANSWER, Reason.SHORTENED))


@dataclass(frozen=True)
class Because:
    """A reason with its sentence."""

    reason: Reason
    sentence: str

    def with_prefix(self, prefix: str) -> "Because":
        return Because(self.reason, prefix + self.sentence)
