# SPDX-License-Identifier: BSD-3-Clause
"""Moves poses in UTM or ECEF coordinates to the origin, because maps hold 32-bit numbers, too coarse for them."""

from __future__ import annotations

from typing import Any

import numpy as np

from voxnav.array_types import Array

# Within this distance 32-bit numbers are exact to half a millimetre, and an OctoMap of 0.2 m reaches as far.
FAR_M = 5000.0


def origin_of(positions: Any) -> Array | None:
    """Returns the shift (3,) in whole metres to subtract from positions (n, 3), or None if they are near their origin.

    The heights are not shifted unless they are as far away themselves.
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
