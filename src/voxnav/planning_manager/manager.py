# SPDX-License-Identifier: BSD-3-Clause
"""The object around the transitions, which holds the state, the inputs and the counters."""

from dataclasses import replace
from typing import Any, Callable, Iterable, List, Optional, Sequence, Tuple, Union

import numpy as np

from voxnav._core import PlanOutcome
from voxnav.array_types import Array
from voxnav.fences.placing import PlacedFences
from voxnav.planning_manager import checking, flying, main_loop, planning, stopping
from voxnav.planning_manager.actions import Action, Hover, Plan, Publish
from voxnav.planning_manager.facts import Facts, Step
from voxnav.planning_manager.generated import Generated
from voxnav.planning_manager.inputs import (Control, Fencing, Frames, Inputs, Limits, Prediction, Timed, Vehicle,
                                            jump_m, problem_of_limits)
from voxnav.planning_manager.owners import who_flies
from voxnav.planning_manager.reasons import Because, Reason
from voxnav.planning_manager.refusal import refusal_of
from voxnav.planning_manager.states import Goal, Idle, Moving, Planning, State, flight_of
from voxnav.planning_manager.status import Status

MAX_GOAL_DISTANCE_M = 1e5
CLOCK_JUMP_S = 1.0


class PlanningManager:
    """The states Idle, Planning and Moving, without ROS, threads and clocks.

    It is told the time [s] and what has happened, and answers with the actions to be done. Searching and services run
    elsewhere; their answers come back by the calls ending in ``_done``, and answers to jobs that no longer matter are
    ignored.

    The vehicle always holds a trajectory that ends at rest in known free space; when that is no longer so, the
    trajectory is shortened, or the vehicle brakes. Whatever is lost (odometry, map, correction, services) leads to
    hover with a reason; the goal is kept and the flight resumes. Not thread-safe.
    Source: docs/architecture.md, "From a goal to a trajectory"; formulas in docs/maths/planning.md.
    """

    def __init__(self, config: Any, altitudes_m: Tuple[float, float], look: Callable[[], Any]) -> None:
        """Starts in Idle.

        config: voxnav.PlanningManagerConfig; altitudes_m: lowest and highest one of goals, frame W; look: returns the
        newest map as voxnav.OccupancyView, None if there is none, which counts as unsafe
        """
        self._config, self._altitudes_m, self._look = config, altitudes_m, look
        self._state: State = Idle(Because(Reason.NO_GOAL, "no goal"))
        self._inputs = Inputs()
        self._last_now_s: Optional[float] = None
        self._num_jobs, self._jump_m = 0, 0.0
        # Tells why a goal in frame W is refused for reasons of others, None if it is not.
        self.judge: Callable[[Array], Optional[Because]] = lambda goal_W: None
        self._status = Status()

    # Inputs: vehicle and maps.

    def set_vehicle(self, stamp_s: float, position_O: Sequence[float], velocity_O: Sequence[float]) -> None:
        """Sets the vehicle's state, which must be finite; a jump is handled on the next tick."""
        timed = Timed(stamp_s, Vehicle(np.asarray(position_O, dtype=float), np.asarray(velocity_O, dtype=float)))
        self._jump_m = max(self._jump_m, jump_m(self._inputs.vehicle, timed))
        self._inputs = replace(self._inputs, vehicle=timed)

    def set_prediction(self, stamp_s: float, times_s: Sequence[float], positions_O: Array,
                       input_id: Optional[int] = None) -> None:
        """Sets the tracker's prediction; one that is not usable counts as lost.

        positions_O: (n, 3); input_id: the number of the tracker's last trajectory, None if it does not tell
        """
        prediction = Prediction(np.asarray(times_s, dtype=float), np.asarray(positions_O, dtype=float), input_id)
        if prediction.is_usable:
            self._inputs = replace(self._inputs, prediction=Timed(stamp_s, prediction))

    def set_control(self, stamp_s: float, control: Control) -> None:
        self._inputs = replace(self._inputs, control=Timed(stamp_s, control))

    def set_limits(self, stamp_s: float, values: Limits) -> None:
        """Sets the limits of the vehicle: pairs of speed and acceleration, horizontal, ascending, descending.

        Limits that cannot be those of a UAV stop the flight, which brakes by the last usable ones.
        """
        problem = problem_of_limits(values)
        limits = self._inputs.limits if problem else Timed(stamp_s, values)
        self._inputs = replace(self._inputs, limits=limits, limits_problem=problem)

    def set_T_W_O(self, stamp_s: float, T_W_O: Array) -> None:
        """Sets the map correction. T_W_O: (4, 4)."""
        self._inputs = replace(self._inputs, T_W_O=Timed(stamp_s, T_W_O))

    def set_map_stamp(self, stamp_s: float) -> None:
        self._inputs = replace(self._inputs, map_stamp_s=stamp_s)

    def set_frames(self, map: str, control: str, correction: str = "") -> None:
        """Sets the frames of the local map, of the odometry, and of the map correction; '' if unknown."""
        self._inputs = replace(self._inputs, frames=Frames(map or None, control or None, correction or None))

    def set_lost_nodes(self, names: Iterable[str]) -> None:
        self._inputs = replace(self._inputs, lost_nodes=frozenset(names))

    def set_fences(self, placed: Optional[PlacedFences], problem: str = "") -> None:
        """Sets the fences, None for no fences. problem: why they are not known; the vehicle does not fly then."""
        self._inputs = replace(self._inputs, fencing=Fencing(placed, problem))

    def set_others_problem(self, problem: str) -> None:
        """Sets why it is not known where other UAVs are, '' if it is; the vehicle does not fly otherwise."""
        self._inputs = replace(self._inputs, others_problem=problem)

    # Commands.

    def set_goal(self, goal_W: Sequence[float], heading_rad: Optional[float], now_s: float) -> str:
        """Sets a goal. Returns why it is refused, or ''. heading_rad: heading at the goal, frame W; None: any."""
        position = np.asarray(goal_W, dtype=float)
        if not np.isfinite(position).all() or (heading_rad is not None and not np.isfinite(heading_rad)):
            return "goal is not finite"
        if np.linalg.norm(position) > MAX_GOAL_DISTANCE_M:
            return "goal is more than 100 km from the map's origin"
        low, high = self._altitudes_m
        if position[2] < low:
            return "goal is below the lowest altitude of %.1f m" % low
        if position[2] > high:
            return "goal is above the highest altitude of %.1f m" % high
        control = self._facts(now_s).control
        pilot = who_flies(control.value) if control is not None and control.value.is_remote else None
        self._status.refusal = pilot or refusal_of(position, self._inputs) or self.judge(position)
        if self._status.refusal is not None:
            return self._status.refusal.sentence
        self._status.is_goal_reached = False
        self._take(stopping.accept_goal(self._state, Goal(position, heading_rad), self._facts(now_s)))
        return ""

    def refuse_goal(self, goal_W: Array, because: Because, now_s: float) -> List[Action]:
        """Drops a goal that others refuse, unless there is another one by now."""
        goal = self._state.goal
        if goal is None or not np.array_equal(goal.position_W, goal_W):
            return []
        self._status.refusal = because
        return self._take(stopping.drop(self._state, because.with_prefix("goal dropped: "), self._facts(now_s)))

    def stop(self, sentence: str, now_s: float) -> List[Action]:
        """Drops the goal and hovers."""
        return self._take(stopping.stop(self._state, Because(Reason.STOPPED, sentence), self._facts(now_s)))

    def set_altitudes(self, min_m: float, max_m: float) -> None:
        """Sets the lowest and the highest altitude of later goals, frame W."""
        self._altitudes_m = (min_m, max_m)

    # Events: time has passed, or a job has ended.

    def frame_jumped(self, sentence: str, now_s: float) -> List[Action]:
        because = Because(Reason.FRAME_JUMPED, sentence)
        return self._take(stopping.jump_frame(self._state, because, self._facts(now_s)))

    def map_closed(self, sentence: str, now_s: float) -> List[Action]:
        """Takes note that the map was closed in which the goal is. It cannot be expressed in the new one."""
        because = Because(Reason.MAP_CLOSED, "goal dropped: the map was closed: " + sentence)
        return self._take(stopping.close_map(self._state, because, self._facts(now_s)))

    def tick(self, now_s: float) -> List[Action]:
        """Runs one step of the main loop; to be called at 20 Hz."""
        has_jumped = self._last_now_s is not None and now_s < self._last_now_s - CLOCK_JUMP_S
        self._last_now_s = now_s
        if has_jumped:
            self._inputs = Inputs(fencing=self._inputs.fencing)
            return self._take(stopping.jump_clock(self._state, self._facts(now_s)))
        if self._jump_m > 0.0:
            sentence, self._jump_m = "odometry jumped by %.1f m" % self._jump_m, 0.0
            return self.frame_jumped(sentence, now_s)
        return self._take(main_loop.tick(self._state, self._facts(now_s)))

    def check(self, now_s: float) -> List[Action]:
        """Checks whatever the vehicle flies; to be called at 10 Hz."""
        return self._take(checking.check(self._state, self._facts(now_s)))

    def is_wanted(self, action: Action) -> bool:
        """Returns False for a job that no longer matters and need not be started."""
        return isinstance(action, Hover) or self._is_current(action.job)

    def plan_done(self, job: int, outcome: PlanOutcome, now_s: float) -> List[Action]:
        if self._is_current(job):
            self._status.note_search(outcome.plan)
        return self._take(planning.plan_done(self._state, job, outcome, self._facts(now_s)))

    def failed(self, action: Action, problem: str, now_s: float) -> List[Action]:
        """Takes the failure of an action that could not be executed at all, as a refusal with that problem."""
        if isinstance(action, Hover):
            return self.hover_done(problem, now_s)
        if isinstance(action, Plan):
            return self._take(planning.plan_failed(self._state, action.job, problem, self._facts(now_s)))
        if isinstance(action, Publish):
            return self.publish_done(action.job, problem, now_s)
        return self.generate_done(action.job, problem, now_s)

    def generate_done(self, job: int, generated: Union[Generated, str], now_s: float) -> List[Action]:
        """Takes the generator's answer: a trajectory, or why there is none."""
        return self._take(flying.generate_done(self._state, job, generated, self._facts(now_s)))

    def publish_done(self, job: int, problem: str, now_s: float, is_modified: bool = False) -> List[Action]:
        """Takes the control manager's answer to a trajectory. is_modified: it flies another one than was asked for."""
        if self._is_current(job) and not problem:
            self._status.num_trajectories += 1
        return self._take(flying.publish_done(self._state, job, problem, self._facts(now_s), is_modified))

    def hover_done(self, problem: str, now_s: float) -> List[Action]:
        return self._take(stopping.hover_answered(self._state, problem, self._facts(now_s)))

    # Outputs.

    @property
    def inputs(self) -> Inputs:
        return self._inputs

    @property
    def status(self) -> Status:
        state, goal, because = self._state, self._state.goal, self._state.because
        if isinstance(state, Idle) and state.danger is not None:
            told = because.sentence + "; " if because.reason is Reason.TAKEN_OVER else ""
            because = state.danger.with_prefix(told)
        return replace(self._status, state=_NUMBERS[type(state)], because=because,
                       goal_W=None if goal is None else goal.position_W)

    def remaining_path(self, now_s: float) -> Array:
        """Returns the (k, 3) rest of the flown trajectory, frame O; (0, 3) at rest."""
        facts = self._facts(now_s)
        flight = facts.flown(flight_of(self._state))
        if flight is None or self._inputs.vehicle is None:
            return np.zeros((0, 3))
        return np.asarray(flight.trajectory.points_from_arc(flight.arc_m(facts.vehicle.position_O, now_s)))

    def _facts(self, now_s: float) -> Facts:
        facts = Facts(now_s, self._inputs, self._config, self._num_jobs + 1, self._look)
        return facts.blind() if self._inputs.frames.differ else facts

    def _is_current(self, number: int) -> bool:
        return not isinstance(self._state, Idle) and self._state.job is not None and self._state.job.job == number

    def _take(self, step: Step) -> List[Action]:
        self._state, actions = step
        self._status.is_goal_reached |= self._state.because.reason is Reason.REACHED
        for action in actions:
            self._num_jobs += not isinstance(action, Hover)
            self._status.num_plans += isinstance(action, Plan)
            self._status.num_shortened += isinstance(action, Publish) and action.is_shortening
            self._status.num_hovers += isinstance(action, Hover) and not action.is_repeat
        return list(actions)


# As in the message PlannerStatus.
_NUMBERS = {Idle: 0, Planning: 1, Moving: 2}
