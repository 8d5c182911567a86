# SPDX-License-Identifier: BSD-3-Clause
"""Decides when a flight begins, and keeps the way home up to date."""

from __future__ import annotations

import collections
import threading
from dataclasses import dataclass
from typing import Any, Callable, Deque, Optional, Tuple

import numpy as np

from voxnav._core import check_corridor, flight_time
from voxnav.array_types import Array
from voxnav.homing.corrections import MapCorrection, MapCorrections
from voxnav.homing.track import HomeTrack
from voxnav.planning_manager.inputs import Inputs

# The way is kept up to date this often; the vehicle flies no farther than HomeTrack takes for a jump meanwhile.
INTERVAL_S = 0.2
# A vehicle that was on the ground for this long begins a new flight when it is in the air again.
LANDED_S = 3.0
# Shortcuts, whose corridors are costly to check, are looked for this often.
SHORTCUT_INTERVAL_S = 1.0
# Corrections of the map wait for the T_W_O that belongs to them; more than these are applied without it.
MAX_PENDING = 50


@dataclass(frozen=True, eq=False)
class HomeState:
    """Where the flight began, frame W, and the way back; None: not known."""

    start_W: Optional[Array] = None
    way_m: Optional[float] = None
    way_s: Optional[float] = None


class HomeKeeper:
    """Is told the inputs of the planning manager again and again. Not thread-safe, but for what says so.

    radius_m: known free space that must surround a shortcut; deviation_m: how far a trajectory may leave the way
    """

    def __init__(self, radius_m: float, deviation_m: float) -> None:
        self._radius_m, self._deviation_m = radius_m, deviation_m
        self._track: Optional[HomeTrack] = None
        self._now_s = self._shortened_s = 0.0
        self._ground_since_s: Optional[float] = None
        self._lock = threading.Lock()  # protects the next three
        self._corrections = MapCorrections()
        self._pending: Deque[Tuple[MapCorrection, Array]] = collections.deque()
        self._closed: Optional[str] = None  # why the map was closed in which the start is; None: it was not
        self._lost = ""
        self.state = HomeState()

    @property
    def lost(self) -> str:
        """Why the start of this flight is no longer known; '' if it is, or if nothing flies."""
        return self._lost

    @property
    def way_W(self) -> Optional[Array]:
        """Returns the way from the vehicle to the start, (k, 3); None if it is not known. Thread-safe."""
        track = self._track  # a search asks in a thread of its own, while a landing may take the way away
        return None if track is None else track.way_W()

    def correct_map(self, T_W_S: dict[int, Array], T_W_O: Array, odometry_frame: str) -> None:
        """Takes a solution of the graph, which counts from when the inputs have its T_W_O. Thread-safe.

        T_W_S: poses (4, 4) of all submaps by their ids
        """
        with self._lock:
            self._pending.append((self._corrections.take(T_W_S, T_W_O, odometry_frame), np.array(T_W_O)))

    def lose_map(self, sentence: str) -> None:
        """Forgets start and way at the next update, because the map was closed in which they are. Thread-safe."""
        with self._lock:
            self._corrections = MapCorrections()
            self._pending.clear()
            self._closed = sentence

    def update(self, inputs: Inputs, look: Callable[[], Any], now_s: float) -> None:
        """Keeps the way up to date. look: returns voxnav.OccupancyView in frame O, None if there is no map."""
        if now_s < self._now_s:
            self._now_s = self._shortened_s = now_s
            self._ground_since_s = None
        with self._lock:
            closed, self._closed = self._closed, None
        if closed is not None and self._track is not None:
            self._track, self._lost, self.state = None, closed, HomeState()
        if now_s - self._now_s < INTERVAL_S or inputs.vehicle is None or inputs.T_W_O is None:
            return
        if inputs.frames.differ:
            return  # the place of the vehicle in W is not known until the map has followed the vehicle's frame
        self._now_s = now_s
        T_W_O, position_O = inputs.T_W_O.value, inputs.vehicle.value.position_O
        position_W = np.asarray(T_W_O[:3, :3].dot(position_O) + T_W_O[:3, 3])
        self._follow_map(T_W_O)
        if not self._is_flown(inputs, now_s) or self._lost:
            return
        if self._track is None:
            self._track = HomeTrack(position_W)
        self._track.follow(position_W)
        view = look() if now_s - self._shortened_s >= SHORTCUT_INTERVAL_S else None
        if view is not None:
            self._shortened_s = now_s
            self._track.shorten(lambda line_W: self._is_free(line_W, T_W_O, view))
        self.state = self._state_of(self._track, inputs)

    def _is_flown(self, inputs: Inputs, now_s: float) -> bool:
        """Tells whether the vehicle is in the air; one that has landed has no way home until it takes off again."""
        if inputs.is_on_ground:
            self._ground_since_s = now_s if self._ground_since_s is None else self._ground_since_s
            if now_s - self._ground_since_s >= LANDED_S:
                self._track, self._lost, self.state = None, "", HomeState()
            return False
        if inputs.is_in_air:
            self._ground_since_s = None
        return inputs.is_in_air

    def _follow_map(self, T_W_O: Array) -> None:
        """Applies the corrections up to the newest one to which T_W_O belongs."""
        with self._lock:
            known = [number for number, (_, its) in enumerate(self._pending) if np.allclose(its, T_W_O, atol=1e-9)]
            count = max(known[-1] + 1 if known else 0, len(self._pending) - MAX_PENDING)
            due = [self._pending.popleft()[0] for _ in range(count)]
        for correction in due:
            if self._track is not None:
                self._track.correct(correction)

    def _is_free(self, line_W: Array, T_W_O: Array, view: Any) -> bool:
        line_O = np.ascontiguousarray((line_W - T_W_O[:3, 3]) @ T_W_O[:3, :3])
        return bool(check_corridor(view, line_O, self._radius_m).safe)

    def _state_of(self, track: HomeTrack, inputs: Inputs) -> HomeState:
        way = track.way_W()
        if way is None:
            return HomeState(track.start_W)
        way_s = None if inputs.limits is None else flight_time(way, inputs.limits.value, self._deviation_m)
        return HomeState(track.start_W, track.length_m(), way_s)
