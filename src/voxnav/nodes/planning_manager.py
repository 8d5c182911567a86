# SPDX-License-Identifier: BSD-3-Clause
"""The planning_manager node: rospy around voxnav.planning_manager, which decides everything."""

import contextlib
import threading
import traceback

import numpy as np
import rospy
from mrs_msgs.srv import TransformReferenceSrv

import voxnav
from voxnav.homing import or_way_home, way_in_O
from voxnav.msg import NodeDiagnostics
from voxnav.nodes.kept_goal import KeptGoal
from voxnav.nodes.node_base import Diagnostics, run_node
from voxnav.nodes.params import load_sections
from voxnav.nodes.path_service import PathService
from voxnav.nodes.planning_fences import PlanningFences
from voxnav.nodes.planning_goals import PlanningGoals
from voxnav.nodes.planning_headings import Headings
from voxnav.nodes.planning_home import PlanningHome
from voxnav.nodes.planning_inputs import PlanningInputs
from voxnav.nodes.planning_others import PlanningOthers
from voxnav.nodes.planning_output import PlanningOutput
from voxnav.nodes.planning_services import ControlServices, TimedService
from voxnav.nodes.planning_settings import PlanningSettings
from voxnav.nodes.planning_validation import GoalValidation
from voxnav.nodes.time_seam import WorkTimes, seam_for
from voxnav.nodes.virtual_obstacles import VirtualObstacles
from voxnav.planning_manager import Generate, Hover, Level, Plan, PlanningManager, Publish, Reason

NAME = "planning_manager"


class PlanningManagerNode:
    def __init__(self):
        node, manager, planner, limits, fences, home, heading, others, work, time_config = load_sections(
            node=voxnav.PlanningNodeConfig, manager=voxnav.PlanningManagerConfig, planner=voxnav.FlightSearchConfig,
            map=voxnav.NavigationMapConfig, fences=voxnav.FencesConfig, home=voxnav.HomeConfig,
            heading=voxnav.HeadingConfig, others=voxnav.OtherUavsConfig,
            work=voxnav.WorkTimeConfig, time=voxnav.TimeConfig)
        self._seam = seam_for(time_config, NAME)
        self._manager_config = manager
        self._map = voxnav.NavigationMap(limits)
        self._manager = PlanningManager(manager, (limits.min_altitude_m, limits.max_altitude_m), self._map.view)
        self._lock = threading.RLock()  # protects the manager
        self._settings = PlanningSettings(planner, limits, manager, self._set_altitudes)
        self._revision, self._search = self._settings.search(0, None)  # used by the thinker alone
        self._doers = {Plan: self._do_plan, Generate: self._do_generate, Publish: self._do_publish,
                       Hover: self._do_hover}
        self._waypoints, self._last_now, self._told = np.zeros((0, 3)), 0.0, None
        self._kept = KeptGoal(NAME, node.keep_goal_over_restart)
        self._diagnostics = Diagnostics(NAME)
        self._output = PlanningOutput()
        self._services = ControlServices(node, manager.trajectory_deviation_m, Headings(heading), self._seam)
        self._executors = self._make_executors(work)
        self._inputs = PlanningInputs(node, self._manager, self._map, self._lock, self._on_jump, self._on_closed,
                                      self._seam)
        uav_name = rospy.get_namespace().strip("/").split("/")[0]
        transform = TimedService("~transform_reference_out", TransformReferenceSrv, node.service_timeout_s, self._seam)
        self._goals = PlanningGoals(self._inputs, uav_name, self._set_goal, self._stop, transform)
        self._fences = PlanningFences(fences, self._inputs, uav_name, self._set_fences, self._seam)
        self._others = PlanningOthers(others, self._inputs, uav_name, self._fences, self._set_others, self._seam)
        self._virtual_obstacles = VirtualObstacles(self._fences, self._inputs)
        self._validation = GoalValidation(node, self._inputs, lambda: self._manager.inputs.fencing, self._refuse_goal,
                                          self._seam)
        self._home = PlanningHome(home, manager, self._manager, self._map.view, self._set_goal, self._seam)
        self._manager.judge = self._home.judge
        self._inputs.on_graph = self._home.correct_map
        self._paths = PathService(self._settings, self._map.view, self._goals.to_map,
                                  lambda: (self._inputs.T_W_O, self._inputs.odometry_frame))
        self._resume_kept_goal()
        # The check of the flight comes first: where the seam calls them in turn, it runs before anything new starts.
        self._seam.every(node.check_rate_hz, self._check)
        self._seam.every(node.main_rate_hz, self._tick)
        self._seam.every(node.status_rate_hz, self._show)

    def _make_executors(self, work):
        """Makes the executor of each kind of action. work: voxnav.WorkTimeConfig."""
        def executor(name, bounds_s, acts_last):
            return self._seam.executor(name, self._do, WorkTimes(bounds_s, work.seed), acts_last)

        # Publishing must not wait behind a search or a generator, and stopping behind nothing.
        thinker = executor("thinker", {Plan: work.search_s, Generate: work.generator_s}, False)
        return {Plan: thinker, Generate: thinker, Publish: executor("commander", {Publish: work.command_s}, True),
                Hover: executor("stopper", {Hover: work.command_s}, True)}

    # Timers

    def _tick(self):
        now = self._seam.now()
        if now.to_sec() < self._last_now - 1.0:
            rospy.logwarn("[%s]: the clock jumped back", NAME)
            self._inputs.reset()
        self._last_now = now.to_sec()
        with self._diagnostics.time("tick"):
            self._inputs.update(now.to_sec())
            self._fences.update()
            self._home.update(now.to_sec())
            self._validation.update()
            with self._lock:
                actions = self._manager.tick(now.to_sec())
            self._dispatch(actions)

    def _check(self):
        with self._diagnostics.time("check"):
            self._others.update()
            with self._lock:
                actions = self._manager.check(self._seam.now().to_sec())
            self._dispatch(actions)

    def _show(self):
        with self._lock:
            status = self._manager.status
            path = self._manager.remaining_path(self._seam.now().to_sec())
        inputs = self._inputs
        T, p = inputs.T_W_O, inputs.position_O
        position_W = None if T is None or p is None else T[:3, :3].dot(p) + T[:3, 3]
        waypoints = self._waypoints if status.goal_W is not None else path[:0]
        self._output.publish(self._seam.now(), status, self._home.state, self._home.way_W, inputs, path,
                             waypoints, position_W)
        self._kept.keep(status.goal_W)
        self._report(status)

    def _tell_if_idle(self, status):
        """Logs why no goal is flown to any more. Stops and flights are logged when they are commanded."""
        reason = status.because.reason if status.state == 0 else None
        if reason is not self._told and reason not in (None, Reason.NO_GOAL):
            say = rospy.loginfo if reason is Reason.REACHED else rospy.logwarn
            say("[%s]: idle: %s", NAME, status.reason)
        self._told = reason

    def _report(self, status):
        self._tell_if_idle(status)
        is_kept_from_flying = status.because.reason.level is Level.WARN
        told = [status.reason if is_kept_from_flying else "", self._home.warning, self._others.warning,
                self._validation.problem]
        problem = "; ".join(text for text in told if text)
        self._diagnostics.set_level(NodeDiagnostics.WARN if problem else NodeDiagnostics.OK, problem)
        for name in ("num_plans", "num_trajectories", "num_shortened", "num_hovers", "expansions"):
            self._diagnostics.set_counter(name, getattr(status, name))
        self._diagnostics.set_counter("num_bad_inputs", self._inputs.num_bad)
        self._diagnostics.set_counter("num_goals_refused", self._validation.num_refused)
        for name, value in self._others.counters().items():
            self._diagnostics.set_counter(name, value)
        self._diagnostics.set_counter("num_snapshots", self._inputs.local.num_snapshots)

    # Commands

    def _set_goal(self, goal_W, heading_W):
        with self._lock:
            problem = self._manager.set_goal(goal_W, heading_W, self._seam.now().to_sec())
        if not problem:
            rospy.loginfo("[%s]: goal (%.1f, %.1f, %.1f)", NAME, *goal_W)
            self._validation.set_goal(goal_W, heading_W)
        return problem

    def _refuse_goal(self, goal_W, because):
        with self._lock:
            actions = self._manager.refuse_goal(goal_W, because, self._seam.now().to_sec())
        self._dispatch(actions)

    def _set_fences(self, placed, problem):
        self._map.set_fences(None if placed is None else placed.fences)
        with self._lock:
            self._manager.set_fences(placed, problem)

    def _set_others(self, others, problem):
        """others: a list of voxnav.OtherUav; None leaves them where they were."""
        if others is not None:
            self._map.set_others(others)
        with self._lock:
            self._manager.set_others_problem(problem)

    def _set_altitudes(self, min_m, max_m):
        self._map.set_altitudes(min_m, max_m)
        with self._lock:
            self._manager.set_altitudes(min_m, max_m)

    def _stop(self):
        with self._lock:
            actions = self._manager.stop("stopped by command", self._seam.now().to_sec())
        self._dispatch(actions)
        return "stopping"

    def _on_jump(self, reason):
        rospy.logwarn("[%s]: %s", NAME, reason)
        self._others.odometry_jumped()
        with self._lock:
            actions = self._manager.frame_jumped(reason, self._seam.now().to_sec())
        self._dispatch(actions)

    def _on_closed(self, reason):
        rospy.logerr("[%s]: the map was closed: %s", NAME, reason)
        self._home.lose_map(reason)
        with self._lock:
            actions = self._manager.map_closed(reason, self._seam.now().to_sec())
        self._dispatch(actions)

    # Actions

    def _dispatch(self, actions):
        for action in actions:
            if isinstance(action, (Hover, Publish)):
                rospy.loginfo("[%s]: %s: %s", NAME, action.name, action.because.sentence)
            self._executors[type(action)].submit(action)

    def _do(self, action):
        """Executes an action. Returns what passes its answer to the manager; None if there is none."""
        with self._lock:
            is_wanted = self._manager.is_wanted(action)
        if is_wanted:
            with self._failures_answered(action), self._diagnostics.time(action.name):
                finish = self._doers[type(action)](action)
                return lambda: self._answer(action, finish)
        return None

    def _answer(self, action, finish):
        actions = []
        with self._failures_answered(action), self._lock:
            actions = finish(self._seam.now().to_sec())
        self._dispatch(actions)

    @contextlib.contextmanager
    def _failures_answered(self, action):
        """Passes a failure of an action to the manager, where it becomes a reason.

        That holds for any failure: one that ended the thread would end all later searches, or stops, in silence.
        """
        try:
            yield
        except Exception as error:
            rospy.logerr("[%s]: %s failed: %s\n%s", NAME, action.name, error, traceback.format_exc())
            with self._lock:
                actions = self._manager.failed(action, str(error) or type(error).__name__, self._seam.now().to_sec())
            self._dispatch(actions)

    def _do_plan(self, action):
        view, limits = self._map.view(), self._inputs.limits
        if view is None or limits is None:
            raise ValueError("no map or no constraints")
        self._revision, self._search = self._settings.search(self._revision, self._search)
        search = self._search
        with self._diagnostics.time("field"):
            search.field.update(view)
        outcome = voxnav.run_plan_job(search.planner, search.field, self._manager_config, view, action.start_O,
                                      action.goal_O, limits)
        outcome = or_way_home(outcome, way_in_O(self._home.way_W, action.goal_O, self._inputs.T_W_O), lambda way_O:
                              voxnav.run_way_job(self._manager_config, view, action.start_O, action.goal_O, limits,
                                                 way_O))
        self._waypoints = outcome.waypoints_O
        return lambda now: self._manager.plan_done(action.job, outcome, now)

    def _do_generate(self, action):
        generated = self._services.generate(action, self._inputs.odometry_frame, self._inputs.heading_O_rad,
                                            self._seam.now().to_sec())
        return lambda now: self._manager.generate_done(action.job, generated, now)

    def _do_publish(self, action):
        problem, is_modified = self._services.publish(action.trajectory, action.stamp_s, self._inputs.odometry_frame)
        return lambda now: self._manager.publish_done(action.job, problem, now, is_modified)

    def _do_hover(self, action):
        problem = self._services.stop(action, self._inputs.odometry_frame)
        if problem:
            rospy.logerr("[%s]: %s fails: %s", NAME, action.means.value, problem)
        return lambda now: self._manager.hover_done(problem, now)

    def _resume_kept_goal(self):
        goal_W = self._kept.find()
        if goal_W is not None:
            rospy.logwarn("[%s]: takes up the goal it was flying to", NAME)
            self._set_goal(goal_W, None)


def main():
    run_node(NAME, PlanningManagerNode)
