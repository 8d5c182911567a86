# SPDX-License-Identifier: BSD-3-Clause
"""The way home of the planner: keeps it, serves the return, and reads the battery."""

import math

import numpy as np
import rospy
from sensor_msgs.msg import BatteryState
from std_srvs.srv import Trigger, TriggerResponse

from voxnav.homing import Battery, HomeKeeper, ReserveWatch, Watch, beyond_reserve, watch_reserve
from voxnav.homing.known_way import SAME_PLACE_M
from voxnav.homing.reserve import Trip
from voxnav.planning_manager import Reason

WARNING_INTERVAL_S = 10.0


class PlanningHome:
    """Keeps the way home.

    config: voxnav.HomeConfig; manager: the PlanningManager, of which only inputs and status are read; look(): returns
    the newest map; set_goal(goal_W, heading): returns a problem
    """

    def __init__(self, config, manager_config, manager, look, set_goal, seam):
        """manager_config: voxnav.PlanningManagerConfig"""
        self._config, self._manager, self._look, self._set_goal, self._seam = config, manager, look, set_goal, seam
        self._keeper = HomeKeeper(manager_config.corridor_radius_m, manager_config.trajectory_deviation_m)
        self._battery = None
        self._watch = ReserveWatch(Watch.SILENT)
        self._goal_W = None  # the start, while it is the goal because of a return
        self._has_returned = False  # by itself, in this flight
        rospy.Subscriber("~battery_in", BatteryState, self._on_battery, queue_size=1)
        rospy.Service("~return_home", Trigger, self._serve_return)

    @property
    def state(self):
        """Returns the voxnav.homing.HomeState."""
        return self._keeper.state

    @property
    def way_W(self):
        """Returns the way from the vehicle to the start, (k, 3); None if it is not known."""
        return self._keeper.way_W

    @property
    def warning(self):
        """What is to be told of the battery in flight; '' if nothing is."""
        return self._watch.sentence

    def correct_map(self, T_W_S, T_W_O, odometry_frame):
        """Takes a solution of the graph, as HomeKeeper.correct_map does."""
        self._keeper.correct_map(T_W_S, T_W_O, odometry_frame)

    def lose_map(self, sentence):
        """Takes note that the map was closed."""
        self._keeper.lose_map(sentence)

    def update(self, now_s):
        """Keeps the way home; to be called by the main loop."""
        self._keeper.update(self._manager.inputs, self._look, now_s)
        self._watch_battery(now_s)
        self._follow_start()

    def judge(self, goal_W):
        """Tells why the battery does not hold for a goal, as a Because; None if it does."""
        inputs = self._manager.inputs
        if inputs.vehicle is None or inputs.T_W_O is None or inputs.limits is None:
            return None
        T, position_O = inputs.T_W_O.value, inputs.vehicle.value.position_O
        trip = Trip(np.asarray(goal_W), T[:3, :3].dot(position_O) + T[:3, 3], self.state, inputs.limits.value)
        return beyond_reserve(trip, self._battery, self._config, self._seam.now().to_sec())

    def _on_battery(self, msg):
        is_measured = math.isfinite(msg.percentage) and 0.0 <= msg.percentage <= 1.0
        self._battery = Battery(self._seam.now().to_sec(), float(msg.percentage) if is_measured else None)

    def _watch_battery(self, now_s):
        before, self._watch = self._watch, watch_reserve(self.state, self._battery, self._config, now_s)
        if self._watch.watch is Watch.SILENT:
            self._has_returned = False
        elif self._watch.watch is Watch.REACHED:
            rospy.logwarn_throttle(WARNING_INTERVAL_S, self._watch.sentence)
            if self._config.return_at_reserve and not self._has_returned:
                self._return_by_itself()
        elif self._watch.sentence and self._watch != before:
            rospy.logwarn(self._watch.sentence)

    def _return_by_itself(self):
        """Makes the start the goal once in a flight, unless somebody else flies the vehicle."""
        control = self._manager.inputs.control
        if control is None or not control.value.is_free:
            return
        if self._manager.status.because.reason is Reason.TAKEN_OVER:
            return
        problem = self._return()
        self._has_returned = not problem
        if problem:
            rospy.logerr_throttle(WARNING_INTERVAL_S, "no return because of the battery: %s", problem)
        else:
            rospy.logwarn("returns to its start because of the battery")

    def _follow_start(self):
        """Sets the goal anew when the start to which the vehicle returns has moved with the map."""
        goal_W, start_W = self._manager.status.goal_W, self.state.start_W
        is_returning = self._goal_W is not None and goal_W is not None and np.array_equal(goal_W, self._goal_W)
        if not is_returning or start_W is None:
            return
        if np.linalg.norm(start_W - goal_W) > SAME_PLACE_M:
            rospy.loginfo("the start has moved with the map by %.2f m", np.linalg.norm(start_W - goal_W))
            self._return()

    def _return(self):
        """Makes the start the goal. Returns a problem, or ''."""
        start_W = self.state.start_W
        if start_W is None:
            lost = self._keeper.lost
            return "no start is known: " + ("the map was closed: " + lost if lost else "the vehicle does not fly")
        problem = self._set_goal(start_W, None)
        if not problem:
            self._goal_W = np.array(start_W)
        return problem

    def _serve_return(self, _):
        state, problem = self.state, self._return()
        way = "" if state.way_m is None else ", %.0f m" % state.way_m
        way += "" if state.way_s is None else ", %.0f s" % state.way_s
        return TriggerResponse(success=not problem, message=problem or "returns to its start" + way)
