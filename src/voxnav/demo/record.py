# SPDX-License-Identifier: BSD-3-Clause
"""The record of a flight: plain data, filled by ``voxnav.nodes.flight_recorder``."""

from __future__ import annotations

from typing import Any

import numpy as np

from voxnav.array_types import Array, ArrayLike


class Track:
    """Stamped positions that only grow."""

    def __init__(self) -> None:
        self._stamps: list[float] = []
        self._positions: list[ArrayLike] = []

    def add(self, stamp: float, position: ArrayLike) -> None:
        if not self._stamps or stamp > self._stamps[-1]:
            self._positions.append(position)
            self._stamps.append(stamp)

    def arrays(self) -> tuple[Array, Array]:
        """Returns (stamps (n,), positions (n, 3)); another thread may add to them meanwhile."""
        n = len(self._stamps)  # positions come first: there are never fewer
        return np.array(self._stamps[:n]), np.array(self._positions[:n]).reshape(-1, 3)


class FlightRecord:
    """The measurements of one flight; values that were not measured are None."""

    def __init__(self, world: str, seed: int | None = None) -> None:
        self.world, self.seed = world, seed
        self.title = world if seed is None else "%s, seed %d" % (world, seed)
        self.reached, self.reason = False, "the flight did not begin"
        self.goal: Array | None = None
        self.min_clearance_m: float | None = None
        self.has_collided: bool | None = None
        self.num_hovers: int | None = None
        self.num_shortened: int | None = None  # trajectories that were shortened in flight
        self.real_time_factor: float | None = None
        self.speed_factor = 1.0  # the requested factor
        self.truth_track, self.odometry_track = Track(), Track()
        self.optimised: tuple[Array, Array] = (np.empty(0), np.empty((0, 3)))
        self.optimised_poses: Array = np.empty((0, 4, 4))  # at the same stamps
        self.mission: tuple[float, float] | None = None
        self.stages: dict[str, Any] = {}
        self.rss_mb: dict[str, float] = {}
        self.dropped_in_flight: dict[str, int] = {}  # dropped messages by stage
        self.obstacle_points: Array = np.empty((0, 3))
        self.surface_points: Array = np.empty((0, 3))  # surface of the global map
        self.plans: list[Any] = []

    @property
    def truth(self) -> tuple[Array, Array]:
        return self.truth_track.arrays()

    @property
    def odometry(self) -> tuple[Array, Array]:
        return self.odometry_track.arrays()

    def until_its_end(self, track: tuple[Array, Array]) -> tuple[Array, Array]:
        """Returns the part of (stamps (n,), positions (n, 3)) up to the end of the mission."""
        stamps, positions = track
        inside = stamps <= (np.inf if self.mission is None else self.mission[1])
        return stamps[inside], positions[inside]

    def flown_during_mission(self) -> tuple[Array, Array]:
        """Returns the path from the goal's arrival to the end of the mission, by odometry if the truth is unknown."""
        stamps, positions = self.truth if len(self.truth[0]) else self.odometry
        if self.mission is None or not len(stamps):
            return np.empty(0), np.empty((0, 3))
        inside = (stamps >= self.mission[0]) & (stamps <= self.mission[1])
        return stamps[inside], positions[inside]
