# SPDX-License-Identifier: BSD-3-Clause
"""The way home of the planner: keeps it, serves the return, and reads the battery."""

import math

import numpy as np
import rospy
from sensor_msgs.msg import BatteryState
from std_srvs.srv import Trigger, TriggerResponse

from voxnav.homing import Battery, HomeKeeper, beyond_reserve, reserve_warning
from voxnav.homing.reserve import Trip

WARNING_INTERVAL_S = 10.0


class PlanningHome:
    """Keeps the way home.

    config: voxnav.HomeConfig; manager_config: voxnav.PlanningManagerConfig; inputs(): returns the manager's inputs;
    look(): returns the newest map; set_goal(goal_W, heading): returns a problem
    """

    def __init__(self, config, manager_config, inputs, look, set_goal, seam):
        self._config, self._inputs, self._look, self._set_goal, self._seam = config, inputs, look, set_goal, seam
        self._keeper = HomeKeeper(manager_config.corridor_radius_m, manager_config.trajectory_deviation_m)
        self._battery = None
        self.warning = ""  # in flight, that it is time to return
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

    def update(self, now_s):
        """Keeps the way home; to be called by the main loop."""
        self._keeper.update(self._inputs(), self._look, now_s)
        self.warning = reserve_warning(self.state, self._battery, self._config, now_s)
        if self.warning:
            rospy.logwarn_throttle(WARNING_INTERVAL_S, self.warning)

    def judge(self, goal_W):
        """Tells why the battery does not hold for a goal, as a Because; None if it does."""
        inputs = self._inputs()
        if inputs.vehicle is None or inputs.T_W_O is None or inputs.limits is None:
            return None
        T, position_O = inputs.T_W_O.value, inputs.vehicle.value.position_O
        trip = Trip(np.asarray(goal_W), T[:3, :3].dot(position_O) + T[:3, 3], self.state, inputs.limits.value)
        return beyond_reserve(trip, self._battery, self._config, self._seam.now().to_sec())

    def _on_battery(self, msg):
        is_measured = math.isfinite(msg.percentage) and 0.0 <= msg.percentage <= 1.0
        self._battery = Battery(self._seam.now().to_sec(), float(msg.percentage) if is_measured else None)

    def _serve_return(self, _):
        state = self.state
        if state.start_W is None:
            return TriggerResponse(success=False, message="no start is known: the vehicle does not fly")
        problem = self._set_goal(state.start_W, None)
        way = "" if state.way_m is None else ", %.0f m" % state.way_m
        way += "" if state.way_s is None else ", %.0f s" % state.way_s
        return TriggerResponse(success=not problem, message=problem or "returns to its start" + way)
