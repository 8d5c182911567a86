# SPDX-License-Identifier: BSD-3-Clause
"""Shows each new goal to validate_reference of the MRS control manager, whose safety area may be another one."""

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
import rospy
from mrs_msgs.srv import ValidateReference, ValidateReferenceRequest

from voxnav.nodes.planning_services import ServiceError, TimedService, reference
from voxnav.planning_manager import Because, Reason


@dataclass(frozen=True, eq=False)
class Shown:
    """A goal, in frame W for the planner and in O for the control manager."""

    goal_W: Any
    goal_O: Any
    frame: str
    heading_rad: float


class GoalValidation:
    """Asks once for each goal, in a thread of its own, and calls refuse(goal_W, because) if the goal is refused.

    is_enabled: False asks for nothing; inputs: PlanningInputs; fencing(): returns the Fencing of the planner, whose
    area tells that only the straight way is refused
    """

    def __init__(self, config, inputs, fencing, refuse, seam):
        """config: voxnav.PlanningNodeConfig"""
        self._is_enabled, self._inputs, self._fencing, self._refuse = config.validate_goals, inputs, fencing, refuse
        self._service = TimedService("~validate_reference_out", ValidateReference, config.service_timeout_s, seam)
        self._executor = seam.executor("validator", self._ask)
        self._new_goal = None  # (goal_W, heading_W) that was not shown yet
        self.problem = ""  # why the last goal was not validated; '' if it was
        self.num_refused = 0

    def set_goal(self, goal_W, heading_W):
        """Takes a goal that was set."""
        self._new_goal = (np.array(goal_W, dtype=float), heading_W)

    def update(self):
        """Shows a new goal once its place in O is known; to be called by the main loop."""
        inputs, new = self._inputs, self._new_goal
        T_W_O = inputs.T_W_O
        if not self._is_enabled or new is None or T_W_O is None or not inputs.odometry_frame:
            return
        self._new_goal = None
        goal_W, heading_W = new
        heading_O = 0.0 if heading_W is None else heading_W - float(np.arctan2(T_W_O[1, 0], T_W_O[0, 0]))
        goal_O = T_W_O[:3, :3].T.dot(goal_W - T_W_O[:3, 3])
        self._executor.submit(Shown(goal_W, goal_O, inputs.odometry_frame, heading_O))

    def _ask(self, shown):
        request = ValidateReferenceRequest()
        request.reference.header.frame_id = shown.frame
        request.reference.reference = reference(shown.goal_O, shown.heading_rad)
        try:
            answer = self._service.call(request)
        except ServiceError as error:
            self.problem = "the control manager was not asked about the goal: %s" % error
            rospy.logwarn(self.problem)
            return None
        self.problem = ""
        if answer.success:
            return None
        return lambda: self._take_refusal(shown, answer.message or "without a reason")

    def _take_refusal(self, shown, message):
        if is_round_the_corner(self._fencing().placed, self._inputs.position_O, shown.goal_O):
            rospy.loginfo("the control manager refuses the straight way to the goal (%s), which is not flown", message)
            return
        self.num_refused += 1
        self._refuse(shown.goal_W, Because(Reason.GOAL_REFUSED, "the control manager refuses the goal: " + message))


def is_round_the_corner(placed: Optional[Any], position_O: Optional[Any], goal_O: Any) -> bool:
    """Tells whether a goal is within the fences and the straight way to it is not.

    MRS refuses a reference for the straight way, too, which it would fly itself; voxnav flies round the fences. Where
    voxnav knows no fences that the straight way leaves, the refusal is because of the goal, or of an area of which
    voxnav does not know.
    """
    if placed is None or position_O is None or placed.fences.area is None:
        return False
    fences = placed.fences
    return fences.contact(goal_O) is None and fences.first_touch(position_O, goal_O) is not None
