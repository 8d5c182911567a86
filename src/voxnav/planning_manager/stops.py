# SPDX-License-Identifier: BSD-3-Clause
"""Chooses how the vehicle is stopped: each way to rest is checked, and the least dangerous one is taken."""

from dataclasses import dataclass
from typing import Any, Iterator, Optional, Tuple

from voxnav._core import Trajectory
from voxnav.planning_manager.actions import Hover, Means
from voxnav.planning_manager.facts import Facts
from voxnav.planning_manager.reasons import Because
from voxnav.planning_manager.states import Flight, OwnHover
from voxnav.planning_manager.ways import climbing_way, danger_of, following_way, straight_way

# Heights by which a vehicle may climb to pass over what it cannot stop before.
CLIMBS_M = (1.5, 3.0)
# Ways whose speeds at an obstacle differ by less than this [m/s] are equally dangerous; then the simpler one is taken.
SAME_SPEED_MPS = 0.1


@dataclass(frozen=True, eq=False)
class Stop:
    """A way to stop. command: the trajectory for the tracker; None where the control manager makes the way itself."""

    means: Means
    command: Optional[Trajectory]
    danger: Tuple[float, float]  # speeds at which it enters occupied and unknown space, in steps of SAME_SPEED_MPS

    @property
    def is_free(self) -> bool:
        return self.danger == (0.0, 0.0)


def stop_for(because: Because, flight: Optional[Flight], facts: Facts) -> Tuple[OwnHover, Hover]:
    """Returns the best stop as the hover to be recorded and the action to be done.

    flight: trajectory along which the vehicle flies; None: none
    """
    stop = best_stop(flight, facts)
    return asked_for(stop, _with_means(because, stop), facts)


def asked_for(stop: Optional[Stop], because: Because, facts: Facts) -> Tuple[OwnHover, Hover]:
    """Returns the record and the action of a stop; None is a hover whose way could not be checked."""
    means = Means.HOVER if stop is None else stop.means
    hover = Hover(because, means=means, trajectory=None if stop is None else stop.command)
    return OwnHover(because, facts.now_s, means=means), hover


def best_stop(flight: Optional[Flight], facts: Facts) -> Optional[Stop]:
    """Returns the least dangerous stop, the simplest of equal ones; None if there is nothing to check against.

    That is without a map, and while the place of the vehicle is not known.
    """
    if not facts.is_vehicle_known:
        return None
    view = facts.look()
    if view is None:
        return None
    best = None
    for stop in _stops(flight, view, facts):
        if stop.is_free:
            return stop
        if best is None or stop.danger < best.danger:
            best = stop
    return best


def _stops(flight: Optional[Flight], view: Any, facts: Facts) -> Iterator[Stop]:
    """Yields the stops from the simplest one on.

    Each is checked with the reaction time before it, but a trajectory for the tracker brakes at once.
    """
    radius_m, reaction_s = facts.config.min_corridor_radius_m, facts.config.reaction_time_s
    now_s = facts.now_s
    yield Stop(Means.HOVER, None, danger_in_steps(straight_way(facts), view, radius_m, now_s))
    if not facts.is_in_motion:
        return
    if flight is not None:
        danger = danger_in_steps(following_way(facts, flight, reaction_s), view, radius_m, now_s)
        yield Stop(Means.FOLLOW, following_way(facts, flight, 0.0), danger)
    for height_m in CLIMBS_M:
        danger = danger_in_steps(climbing_way(facts, height_m, reaction_s), view, radius_m, now_s)
        yield Stop(Means.CLIMB, climbing_way(facts, height_m, 0.0), danger)


def danger_in_steps(way: Trajectory, view: Any, radius_m: float, now_s: float) -> Tuple[float, float]:
    """Returns the speeds at which a way enters occupied and unknown space, in steps of SAME_SPEED_MPS."""
    occupied, unknown = danger_of(way, view, radius_m, now_s)
    return _in_steps(occupied), _in_steps(unknown)


def _in_steps(speed_mps: float) -> float:
    """Rounds a speed, but what enters a place at all does not become free by that."""
    return 0.0 if speed_mps == 0.0 else max(SAME_SPEED_MPS, round(speed_mps / SAME_SPEED_MPS) * SAME_SPEED_MPS)


def _with_means(because: Because, stop: Optional[Stop]) -> Because:
    if stop is None:
        return because
    how = "" if stop.means is Means.HOVER else ", " + stop.means.value
    end = "" if stop.is_free else ", no known free way to rest"
    return Because(because.reason, because.sentence + how + end) if how or end else because
