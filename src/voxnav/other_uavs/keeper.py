# SPDX-License-Identifier: BSD-3-Clause
"""Keeps what other UAVs announced last, and tells where each of them may be by now."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Sequence

import numpy as np

from voxnav.array_types import Array
from voxnav.other_uavs.trajectories import Announced

# A UAV that is predicted to move by less than this is at rest, and does not give way.
REST_M = 0.5


@dataclass(frozen=True, eq=False)
class Other:
    """Another UAV in frame O, as voxnav.OtherUav and voxnav/OtherUav have it.

    body_radius_m: 0 if it is not known where its body is; silent_s: time since it was heard
    """

    name: str
    begin_s: float
    places_O: Array
    radius_m: float
    horizon_s: float
    body_radius_m: float
    gives_way: bool
    silent_s: float


def has_right_of_way(own_name: str, other_name: str, other_priority: int) -> bool:
    """Returns True if this vehicle has the right of way over another one: that of the smaller number, as in MRS.

    MRS takes the number out of the name; of equal ones, and where the name has none, the order of names decides, so
    that exactly one of any two gives way.
    """
    own = re.fullmatch(r"uav(\d+)", own_name)
    if own is not None and int(own.group(1)) != other_priority:
        return int(own.group(1)) < other_priority
    return own_name < other_name


class Keeper:
    """The last announcement of each of the other UAVs. Bounded by their names, which are fixed."""

    def __init__(self, config: Any, own_name: str, names: Sequence[str]) -> None:
        """config: voxnav.OtherUavsConfig; names: of all UAVs, this one may be among them."""
        self._config, self._own_name = config, own_name
        self.names = tuple(sorted(set(names) - {own_name}))
        self._last: dict[str, Announced] = {}
        self._forgotten: set[str] = set()

    def take(self, announced: Announced) -> None:
        """Takes an announcement, which replaces the last one of that UAV."""
        self._last[announced.name] = announced
        self._forgotten.discard(announced.name)

    @property
    def is_empty(self) -> bool:
        return not self._last

    @property
    def never_heard(self) -> list[str]:
        return [name for name in self.names if name not in self._last and name not in self._forgotten]

    @property
    def forgotten(self) -> list[str]:
        """Those that have been silent for so long that only the sensors may tell where they are."""
        return sorted(self._forgotten)

    def silent(self, now_s: float) -> list[str]:
        """Returns the names of those that were not heard lately and are kept clear of where they may be."""
        return [name for name, last in sorted(self._last.items())
                if now_s - last.heard_s > self._config.silent_after_s]

    def forget(self, now_s: float) -> list[str]:
        """Forgets those that are silent for too long. Returns their names."""
        after_s = self._config.forget_after_s
        gone = [name for name, last in self._last.items() if 0.0 < after_s < now_s - last.heard_s]
        for name in gone:
            del self._last[name]
            self._forgotten.add(name)
        return gone

    def others(self, now_s: float, T_O_utm: Array) -> list[Other]:
        """Returns where all that were heard are by now, by name. T_O_utm: (4, 4)."""
        return [self._other(last, now_s, T_O_utm) for _, last in sorted(self._last.items())]

    def _other(self, last: Announced, now_s: float, T_O_utm: Array) -> Other:
        config = self._config
        silent_s = max(0.0, now_s - last.heard_s)
        is_silent = silent_s > config.silent_after_s
        unheard_m = config.silent_growth_mps * (silent_s - config.silent_after_s) if is_silent else 0.0
        radius_m = config.body_radius_m + config.position_error_m + last.rounding_m
        gives_way = has_right_of_way(self._own_name, last.name, last.priority)
        is_at_rest = last.way_m < REST_M + 2.0 * last.rounding_m
        may_trust = gives_way and not is_silent and not is_at_rest
        places = last.places_utm @ T_O_utm[:3, :3].T + T_O_utm[:3, 3]
        return Other(last.name, last.begin_s, np.ascontiguousarray(places),
                     radius_m + min(config.max_growth_m, unheard_m),
                     config.near_horizon_s if may_trust else config.horizon_s,
                     0.0 if is_silent else radius_m, gives_way, silent_s)
