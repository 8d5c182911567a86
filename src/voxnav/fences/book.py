# SPDX-License-Identifier: BSD-3-Clause
"""The fences that are in force: the safety area with its holes, and no-fly zones by name, within limits."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Iterable

import numpy as np
import yaml

from voxnav.fences.prisms import FenceError, FencePrism, checked, read_prism
from voxnav.fences.world_config import WorldFences, load_world_config

# A degree of latitude is about this long.
DEGREE_M = 111000.0


@dataclass(frozen=True)
class Limits:
    """How many fences there may be, and how large."""

    max_zones: int = 100
    max_corners: int = 200
    max_zone_size_m: float = 1000.0
    max_area_size_m: float = 20000.0


class FenceBook:
    """Holds the safety area and the zones. `version` changes with every change. Not thread-safe."""

    def __init__(self, limits: Limits = Limits()) -> None:
        self._limits = limits
        self._world = WorldFences(None, None)
        self._zones: dict[str, FencePrism] = {}
        self.version = 0

    @property
    def world(self) -> WorldFences:
        return self._world

    @property
    def area(self) -> FencePrism | None:
        return self._world.area

    @property
    def zones(self) -> list[FencePrism]:
        """Returns the holes of the area and the zones, in the order in which they came."""
        return list(self._world.holes) + list(self._zones.values())

    @property
    def is_empty(self) -> bool:
        return self.area is None and not self.zones

    def load_world(self, path: str) -> None:
        """Takes the safety area of a world configuration. Raises FenceError; the fences are as before then."""
        world = load_world_config(path)
        for prism in ([] if world.area is None else [world.area]):
            self._check_size(prism, self._limits.max_area_size_m)
        for hole in world.holes:
            self._check_size(hole, self._limits.max_zone_size_m)
        self._check_number(len(world.holes) + len(self._zones))
        self._world = world
        self.version += 1

    def add(self, zone: FencePrism) -> None:
        """Adds a zone, or replaces that of the same name. Raises FenceError; the zones are as before then."""
        self.add_all([zone])

    def add_all(self, zones: Iterable[FencePrism]) -> None:
        """Adds zones, all or none. Raises FenceError."""
        added = dict(self._zones)
        for zone in zones:
            if not zone.name:
                raise FenceError("a zone needs a name")
            self._check_size(checked(zone), self._limits.max_zone_size_m)
            added[zone.name] = zone
        self._check_number(len(self._world.holes) + len(added))
        self._zones = added
        self.version += 1

    def copy(self) -> FenceBook:
        """Returns a book with the same fences, which changes on its own."""
        out = FenceBook(self._limits)
        out._world, out._zones, out.version = self._world, dict(self._zones), self.version
        return out

    def remove(self, name: str) -> None:
        """Removes a zone. Raises FenceError if there is none of that name."""
        if name not in self._zones:
            known = ", ".join(sorted(self._zones)) or "none"
            raise FenceError("there is no zone '%s'; there are: %s" % (name, known))
        del self._zones[name]
        self.version += 1

    def clear(self, prefix: str = "") -> int:
        """Removes the zones whose names begin with a prefix, which are not those of the world configuration.

        Returns how many there were.
        """
        gone = [name for name in self._zones if name.startswith(prefix)]
        for name in gone:
            del self._zones[name]
        self.version += bool(gone)
        return len(gone)

    def load_zones(self, path: str) -> int:
        """Adds the zones of a file `zones: {NAME: {horizontal: ..., vertical: ...}}`. Returns how many they are.

        Raises FenceError that lists every problem; the zones are as before then.
        """
        try:
            with open(path, encoding="utf-8") as file:
                tree = yaml.safe_load(file)
        except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
            raise FenceError("zones %s cannot be read: %s" % (path, " ".join(str(error).split())))
        named = tree.get("zones") if isinstance(tree, dict) else None
        if not isinstance(named, dict):
            raise FenceError("zones %s: section zones is missing" % path)
        zones, problems = [], []
        for name, zone in named.items():
            try:
                zones.append(read_prism(str(name), zone))
            except FenceError as error:
                problems += str(error).splitlines()
        if problems:
            raise FenceError("\n".join("zones %s: %s" % (path, problem) for problem in problems))
        self.add_all(zones)
        return len(zones)

    def save_zones(self, path: str) -> int:
        """Writes the zones, without the holes of the area, so that a crash leaves the old file. Raises FenceError."""
        tree = {"zones": {name: zone.to_tree() for name, zone in self._zones.items()}}
        try:
            with open(path + ".part", "w", encoding="utf-8") as file:
                yaml.safe_dump(tree, file, default_flow_style=None, sort_keys=False)
                file.flush()
                os.fsync(file.fileno())
            os.replace(path + ".part", path)
        except OSError as error:
            raise FenceError("zones cannot be written to %s: %s" % (path, error))
        return len(self._zones)

    def _check_number(self, number: int) -> None:
        if number > self._limits.max_zones:
            raise FenceError("%d zones are more than the %d that are allowed" % (number, self._limits.max_zones))

    def _check_size(self, prism: FencePrism, max_size_m: float) -> None:
        if len(prism.points) > self._limits.max_corners:
            raise FenceError("%s: %d corners are more than the %d that are allowed" % (
                prism.name, len(prism.points), self._limits.max_corners))
        size_m = float(np.ptp(prism.points, axis=0).max()) * (DEGREE_M if prism.is_in_degrees else 1.0)
        size_m = max(size_m, prism.max_z - prism.min_z)
        if size_m > max_size_m:
            raise FenceError("%s: %.0f m are more than the %.0f m that are allowed" % (prism.name, size_m, max_size_m))
