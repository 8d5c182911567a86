# SPDX-License-Identifier: BSD-3-Clause
"""Finds single wrong poses, which are far from the poses before and after, while those are near each other."""

from __future__ import annotations

from typing import Any, Iterator, NamedTuple

import numpy as np

from voxnav.array_types import Array

ALONE = "its pose is alone, far from those before and after"  # the reason for which a pose is left out

# No vehicle moves or rotates faster than this between two poses.
_MAX_SPEED_MPS, _MAX_RATE_RADPS = 100.0, 50.0


class Posed(NamedTuple):
    """A pose T (4, 4) with the message to which it belongs."""

    stamp_ns: int
    T: Array
    payload: Any


def _is_possible(a: Posed, b: Posed) -> bool:
    seconds = 1e-9 * abs(b.stamp_ns - a.stamp_ns)
    turn = np.arccos(np.clip((np.trace(a.T[:3, :3].T @ b.T[:3, :3]) - 1.0) / 2.0, -1.0, 1.0))
    way_m = np.linalg.norm(b.T[:3, 3] - a.T[:3, 3])
    return bool(way_m <= _MAX_SPEED_MPS * seconds + 1e-3 and turn <= _MAX_RATE_RADPS * seconds + 1e-3)


class LonePoses:
    """Holds one pose back until the next one shows whether it is wrong. A lasting jump is not an error here."""

    def __init__(self) -> None:
        self._before: Posed | None = None
        self._held: Posed | None = None

    def add(self, pose: Posed) -> Iterator[tuple[Posed, float | None]]:
        """Adds a pose, and yields those that are certain by now, each with its error in metres if it is wrong."""
        held = self._held
        if held is not None:
            yield held, self._off_m(held, pose)
        self._held = pose

    def end(self) -> Iterator[tuple[Posed, float | None]]:
        if self._held is not None:
            yield self._held, None
        self._held = None

    def _off_m(self, held: Posed, after: Posed) -> float | None:
        before = self._before
        if before is not None and not _is_possible(before, held) and not _is_possible(held, after) \
                and _is_possible(before, after):
            return float(np.linalg.norm(held.T[:3, 3] - before.T[:3, 3]))
        self._before = held
        return None
