# SPDX-License-Identifier: BSD-3-Clause
"""Poses far from their origin, as in UTM or ECEF coordinates, brought near to it: maps are made of 32-bit numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from voxnav.array_types import Array

# Points of 32-bit numbers are good to half a millimetre within this distance, and an OctoMap reaches so far at 0.2 m.
FAR_M = 5000.0


def origin_of(positions: Any) -> Array | None:
    """(3,) what is to be subtracted from positions (n, 3), in whole metres; None where they are near their origin.

    Heights stay as they are, unless they are as far off themselves.
    """
    if not len(positions):
        return None
    middle = np.median(np.asarray(positions, dtype=np.float64), axis=0)
    if np.max(np.abs(middle)) <= FAR_M:
        return None
    origin: Array = np.round(middle)
    if abs(middle[2]) <= FAR_M:
        origin[2] = 0.0
    return origin
