# SPDX-License-Identifier: BSD-3-Clause
"""The way back to where a flight began, through space that was flown through or is known to be free."""

from __future__ import annotations

from typing import Callable, Optional

import numpy as np

from voxnav.array_types import Array
from voxnav.homing.corrections import MapCorrection

# A vehicle that is farther from its last place than this has jumped: the way between the two is not known.
JUMP_M = 5.0
# Shortcuts are looked for up to this distance, which the local map knows, and this many are tried at a time.
SHORTCUT_M, MAX_TRIES = 25.0, 4
# A vehicle that comes back to its way within this distance goes on from there. Nothing fits between two places that are
# so near to each other and in both of which the vehicle was.
REJOIN_M = 0.5


class HomeTrack:
    """Keeps a way from the vehicle back to its start, in the map frame W.

    The way consists of places where the vehicle was, and of straight lines between them: either the vehicle has flown
    along the line, within spacing_m, or is_free found it free. Each place knows the submap with which it moves when the
    graph is corrected. Bounded by max_points; a way that needs more is no longer known. Not thread-safe, but the way
    may be read while it changes.
    """

    def __init__(self, start_W: Array, spacing_m: float = 1.0, max_points: int = 20000) -> None:
        self.start_W = np.array(start_W, dtype=float)
        self._start_submap: Optional[int] = None
        self._spacing_m, self._max_points = spacing_m, max_points
        # From the start on, and the submap of each; None: the way is not known.
        self._points: Optional[list[Array]] = [self.start_W]
        self._submaps: list[Optional[int]] = [None]
        self._last_W = self.start_W

    def follow(self, position_W: Array) -> None:
        """Adds the place to which the vehicle has flown, and leaves out a loop that this closes. O(points)."""
        position = np.array(position_W, dtype=float)
        has_jumped = float(np.linalg.norm(position - self._last_W)) > JUMP_M
        self._last_W = position
        if self._points is None:
            return
        if has_jumped or len(self._points) >= self._max_points:
            self._points = None
        elif np.linalg.norm(position - self._points[-1]) >= self._spacing_m:
            self._points = self._points + [position]
            self._submaps = self._submaps + [None]
        self._rejoin()

    def shorten(self, is_free: Callable[[Array], bool]) -> None:
        """Bends the way straight: from the vehicle to the earliest place near to it that is found free.

        is_free: tells whether a line, (2, 3) in W, is known to be free; it is called MAX_TRIES times at most
        """
        if self._points is None:
            return
        places = np.array(self._points)
        near = np.flatnonzero(np.linalg.norm(places - self._last_W, axis=1) <= SHORTCUT_M)
        candidates = near[near < len(places) - 1]
        for number in candidates[:: max(1, len(candidates) // MAX_TRIES)][:MAX_TRIES]:
            rest = np.vstack([places[number:], self._last_W])
            straight_m = float(np.linalg.norm(self._last_W - places[number]))
            if _length_m(rest) - straight_m < self._spacing_m:
                continue
            if is_free(np.array([self._last_W, places[number]])):
                self._end_after(int(number), self._points, self._last_W, None)
                return

    def correct(self, correction: MapCorrection) -> None:
        """Moves the way, its start and the vehicle with the submaps in which they are. O(points)."""
        start, [self._start_submap] = correction.apply(self.start_W[None], [self._start_submap])
        self.start_W = start[0]
        self._last_W = correction.apply(self._last_W[None], [None])[0][0]
        if self._points is not None:
            moved, self._submaps = correction.apply(np.array(self._points), self._submaps)
            self._points = list(moved)

    def way_W(self) -> Optional[Array]:
        """Returns the way from the vehicle to the start, (k, 3) with k >= 2; None if it is not known."""
        points = self._points
        if points is None:
            return None
        return np.array([self._last_W] + points[::-1])

    def length_m(self) -> Optional[float]:
        """Returns the length of the way; None if it is not known."""
        way = self.way_W()
        return None if way is None else _length_m(way)

    def _rejoin(self) -> None:
        """Leaves out the loop between the vehicle and the earliest line of the way to which it has come back."""
        if self._points is None or len(self._points) < 3:
            return
        places = np.array(self._points[:-1])  # the vehicle is near to the last one anyway
        begins, along = places[:-1], np.diff(places, axis=0)
        shares = np.einsum("ij,ij->i", self._last_W - begins, along) / np.maximum(
            np.einsum("ij,ij->i", along, along), 1e-12)
        nearest = begins + np.clip(shares, 0.0, 1.0)[:, None] * along
        near = np.flatnonzero(np.linalg.norm(nearest - self._last_W, axis=1) < REJOIN_M)
        if len(near):
            self._end_after(int(near[0]), self._points, nearest[near[0]], self._submaps[int(near[0]) + 1])

    def _end_after(self, number: int, points: list[Array], place: Array, submap: Optional[int]) -> None:
        """Ends the way, as seen from the start, at a place that follows the point of that number."""
        self._points = points[:number + 1] + [place]
        self._submaps = self._submaps[:number + 1] + [submap]


def _length_m(line: Array) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
