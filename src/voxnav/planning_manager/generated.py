# SPDX-License-Identifier: BSD-3-Clause
"""The answer of the trajectory generator, and what makes it unusable whatever the map says."""

from dataclasses import dataclass
from typing import List, Optional

import numpy as np

from voxnav._core import PlanOutcome, Trajectory
from voxnav.array_types import Array
from voxnav.planning_manager.facts import Facts
from voxnav.planning_manager.states import AHEAD_S, BEHIND_S

# The trajectory ends this near to the last waypoint, and is no faster than the limits by more than this factor.
END_GAP_M = 0.5
SPEED_SLACK = 1.5
# Predictions begin a little after the time at which they are made.
PREDICTION_BEGIN_S = 0.05


@dataclass(frozen=True, eq=False)
class Generated:
    """A generated trajectory. stamp_s: time of its first point; None: the tracker begins when it takes it."""

    trajectory: Trajectory
    stamp_s: Optional[float]

    def begin_s(self, now_s: float) -> Optional[float]:
        """Returns the time of the first point; the tracker flies a trajectory of the future at once."""
        return None if self.stamp_s is None else min(self.stamp_s, now_s)

    def age_s(self, now_s: float) -> float:
        """Returns how much of the trajectory is over."""
        return 0.0 if self.stamp_s is None else max(0.0, now_s - self.stamp_s)

    def arc_m(self, now_s: float) -> float:
        """Returns the length of the part that is over."""
        points, at = self.trajectory.points, self.age_s(now_s) / self.trajectory.dt_s
        low = min(int(at), len(points) - 1)
        pieces = np.linalg.norm(np.diff(points, axis=0), axis=1)
        return float(pieces[:low].sum() + (pieces[low] * (at - low) if low < len(pieces) else 0.0))

    def distance_m(self, position_O: Array, now_s: float) -> float:
        """Returns the distance of a position from where the trajectory is at about this time.

        The time does not matter to the second: MRS puts the newest prediction before a trajectory whose stamp is that
        of the request.
        """
        age_s = self.age_s(now_s)
        arc_m = self.trajectory.project(position_O, age_s - BEHIND_S, age_s + AHEAD_S)
        return float(np.linalg.norm(position_O - self.trajectory.points_from_arc(arc_m)[0]))


def fault_of(generated: Generated, outcome: PlanOutcome, facts: Facts) -> str:
    """Tells why a generated trajectory is not what was asked for; '' if it is.

    outcome: the plan whose waypoints were to be flown
    """
    trajectory, age_s = generated.trajectory, generated.age_s(facts.now_s)
    if age_s > 0.0 and age_s >= trajectory.duration_s:
        return "answered %.1f s too late, the trajectory is over" % (age_s - trajectory.duration_s)
    gap_m = min(generated.distance_m(place_O, facts.now_s) for place_O in _places(facts))
    if gap_m > facts.config.replan_deviation_m:
        return "the trajectory begins %.1f m from the vehicle" % gap_m
    gap_m = float(np.linalg.norm(trajectory.points[-1] - outcome.waypoints_O[-1]))
    if gap_m > END_GAP_M:
        return "the trajectory ends %.1f m from the place that was asked for" % gap_m
    fastest_mps = _fastest_mps(trajectory)
    limit_mps = max(float(np.hypot(facts.limits[0], max(facts.limits[2], facts.limits[4]))), facts.vehicle.speed_mps)
    if fastest_mps > SPEED_SLACK * limit_mps:
        return "the trajectory jumps, at %.1f m/s" % fastest_mps
    return ""


def _places(facts: Facts) -> List[Array]:
    """Returns the place of the vehicle, and that where the tracker says that it is to be now."""
    predicted = facts.predicted(facts.now_s + PREDICTION_BEGIN_S)
    return [facts.vehicle.position_O] + ([] if predicted is None else [predicted])


def _fastest_mps(trajectory: Trajectory) -> float:
    pieces = np.linalg.norm(np.diff(trajectory.points, axis=0), axis=1)
    return float(pieces.max() / trajectory.dt_s) if len(pieces) else 0.0
