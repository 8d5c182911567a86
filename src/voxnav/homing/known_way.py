# SPDX-License-Identifier: BSD-3-Clause
"""The known way home stands in for a search that finds none."""

from __future__ import annotations

from typing import Callable, Optional

import numpy as np

from voxnav._core import PlanOutcome, PlanStatus
from voxnav.array_types import Array

# A goal this near to the start is the way home.
SAME_PLACE_M = 0.3
# Results of a search that a known way cannot stand in for.
NO_SUBSTITUTE = (PlanStatus.START_FENCED, PlanStatus.GOAL_FENCED, PlanStatus.INVALID_INPUT)


def way_in_O(way_W: Optional[Array], goal_O: Array, T_W_O: Optional[Array]) -> Optional[Array]:
    """Returns the known way home, (k, 3) in O, if it leads to the goal; None if it does not, or if there is none.

    way_W: (k, 3), from the vehicle to the start; T_W_O: (4, 4)
    """
    if way_W is None or T_W_O is None:
        return None
    way_O = np.ascontiguousarray((way_W - T_W_O[:3, 3]) @ T_W_O[:3, :3])
    return way_O if np.linalg.norm(way_O[-1] - goal_O) <= SAME_PLACE_M else None


def or_way_home(searched: PlanOutcome, way_O: Optional[Array], cut: Callable[[Array], PlanOutcome]) -> PlanOutcome:
    """Returns the outcome along the known way where the search found no way to the goal of which a part can be flown.

    way_O: see way_in_O(); cut: returns the outcome along a way, as voxnav.run_way_job does
    """
    is_found = searched.status == PlanStatus.COMPLETE and len(searched.waypoints_O) > 0
    if is_found or way_O is None or searched.status in NO_SUBSTITUTE:
        return searched
    outcome = cut(way_O)
    return outcome if len(outcome.waypoints_O) else searched
