# SPDX-License-Identifier: BSD-3-Clause
"""Goals that are refused when they are set, because of the fences."""

from typing import Optional

import numpy as np

from voxnav._core import FenceKind
from voxnav.array_types import Array
from voxnav.planning_manager.inputs import Inputs
from voxnav.planning_manager.reasons import Because, Reason


def refusal_of(goal_W: Array, inputs: Inputs) -> Optional[Because]:
    """Tells why a goal is refused at once; None if it is not.

    While the place of the fences or of the map is not known, nothing can be told; the search refuses the goal then.
    """
    placed, T_W_O = inputs.fencing.placed, inputs.T_W_O
    if placed is None or T_W_O is None:
        return None
    T = T_W_O.value
    contact = placed.fences.contact(np.asarray(T[:3, :3].T.dot(goal_W - T[:3, 3])))
    if contact is None:
        return None
    reason = Reason.GOAL_OUTSIDE_AREA if contact.kind == FenceKind.AREA else Reason.GOAL_IN_ZONE
    return Because(reason, "goal is " + placed.what(contact))
