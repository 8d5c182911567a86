# SPDX-License-Identifier: BSD-3-Clause
"""How places of the map move when the graph corrects the poses of its submaps."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Optional, Sequence

import numpy as np

from voxnav.array_types import Array


@dataclass(frozen=True, eq=False)
class MapCorrection:
    """How places in frame W move, as (4, 4) matrices that take old to new coordinates.

    moves: of places in a submap, by its id; of_rest: of places that are in no submap yet; newest: the submap to which
    these belong from now on, None if there is no new one
    """

    moves: dict[int, Array] = field(default_factory=dict)
    of_rest: Array = field(default_factory=lambda: np.eye(4))
    newest: Optional[int] = None

    def move_of(self, submap: Optional[int]) -> Array:
        """Returns the move of a place in a submap, None for in none. One that is gone moves with the nearest by id."""
        if submap is None or not self.moves:
            return self.of_rest
        wanted = submap
        return self.moves[min(self.moves, key=lambda each: (abs(each - wanted), each))]

    def apply(self, places: Array, submaps: Sequence[Optional[int]]) -> tuple[Array, list[Optional[int]]]:
        """Returns places (n, 3) and their submaps after the correction. O(n)."""
        moved = np.array(places, dtype=float)
        of_place = np.array(submaps, dtype=object)
        for submap in set(submaps):
            rows = np.flatnonzero(of_place == submap)
            T = self.move_of(submap)
            moved[rows] = moved[rows] @ T[:3, :3].T + T[:3, 3]
        return moved, [self.newest if each is None else each for each in submaps]


class MapCorrections:
    """Compares each solution of the graph with the one before."""

    def __init__(self) -> None:
        self._T_W_S: dict[int, Array] = {}
        self._T_W_O: Optional[Array] = None
        self._frame = ""

    def take(self, T_W_S: dict[int, Array], T_W_O: Array, odometry_frame: str) -> MapCorrection:
        """Takes the poses of a solution; returns what moved. The first one moves nothing.

        T_W_O: the map correction (4, 4) of that solution, for the origin of the name odometry_frame. A switch of the
        estimator changes it, too, but moves nothing in W.
        """
        moves = {number: T @ np.linalg.inv(self._T_W_S[number]) for number, T in T_W_S.items()
                 if number in self._T_W_S}
        of_rest = np.eye(4)
        if self._T_W_O is not None and odometry_frame == self._frame:
            of_rest = T_W_O @ np.linalg.inv(self._T_W_O)
        new = set(T_W_S) - set(self._T_W_S)
        self._T_W_S, self._T_W_O, self._frame = dict(T_W_S), np.array(T_W_O), odometry_frame
        return MapCorrection(moves, of_rest, max(new) if new else None)
