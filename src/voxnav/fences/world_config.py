# SPDX-License-Identifier: BSD-3-Clause
"""Reads the world configuration of the MRS system: the origin of its world frame, and the safety area.

The keys are those of mrs_uav_managers: `world_origin/{units,origin_x,origin_y}`,
`safety_area/{enabled,horizontal,vertical}`. Holes of the area, of which MRS knows only in later versions, are read from
`safety_area/obstacles/{present,obstacle_0,obstacle_1,...}`, each of which is a prism as the area itself.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any

import yaml

from voxnav.fences import utm
from voxnav.fences.prisms import FenceError, FencePrism, read_prism

AREA = "safety_area"
# Keys of the section of obstacles that are no obstacles.
SETTINGS = ("present", "count")


class Units(enum.Enum):
    """The units of the origin of the world frame."""

    UTM = enum.auto()
    LATLON = enum.auto()


UNITS = {"utm": Units.UTM, "latlon": Units.LATLON}


@dataclass(frozen=True)
class WorldOrigin:
    """The origin of the frame world_origin in UTM [m], and the zone to which it belongs; None: it was given in UTM."""

    east_m: float
    north_m: float
    zone: int | None = None
    is_south: bool = False


@dataclass(frozen=True, eq=False)
class WorldFences:
    """area: None if it is not enabled; holes: zones in it that may not be entered."""

    origin: WorldOrigin | None
    area: FencePrism | None
    holes: tuple[FencePrism, ...] = ()


def load_world_config(path: str) -> WorldFences:
    """Reads a file. Raises FenceError naming it."""
    try:
        with open(path, encoding="utf-8") as file:
            return read_world_config(file.read())
    except (OSError, UnicodeDecodeError) as error:
        raise FenceError("world configuration %s cannot be read: %s" % (path, error))
    except FenceError as error:
        raise FenceError("world configuration %s: %s" % (path, error))


def read_world_config(text: str) -> WorldFences:
    """Reads the text of a world configuration. Raises FenceError that lists every problem."""
    try:
        tree = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise FenceError("no YAML: " + " ".join(str(error).split()))
    if not isinstance(tree, dict) or not isinstance(tree.get(AREA), dict):
        raise FenceError("section %s is missing" % AREA)
    problems: list[str] = []
    origin = _attempt(_origin, tree, problems)
    area = tree[AREA]
    if not isinstance(area.get("enabled"), bool):
        problems.append("safety_area/enabled must be true or false, and is %s" % (
            "missing" if "enabled" not in area else repr(area["enabled"])))
    is_enabled = area.get("enabled") is True
    prism = _attempt(lambda tree: read_prism(AREA, tree), area, problems) if is_enabled else None
    holes = (_attempt(_holes, area.get("obstacles"), problems) or ()) if is_enabled else ()
    if problems:
        raise FenceError("\n".join(problems))
    return WorldFences(origin, prism, holes)


def _attempt(read: Any, tree: Any, problems: list[str]) -> Any:
    try:
        return read(tree)
    except FenceError as error:
        problems += str(error).splitlines()
        return None


def _origin(tree: dict[str, Any]) -> WorldOrigin | None:
    section = tree.get("world_origin")
    if section is None:
        return None
    if not isinstance(section, dict):
        raise FenceError("world_origin is no section")
    units, values = str(section.get("units", "")).lower(), []
    for key in ("origin_x", "origin_y"):
        value = section.get(key)
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            what = "missing" if value is None else "%r, not a number" % (value,)
            raise FenceError("world_origin/%s is %s" % (key, what))
        values.append(float(value))
    if units not in UNITS:
        raise FenceError("world_origin/units must be UTM or LATLON, and is %r" % section.get("units"))
    if UNITS[units] is Units.UTM:
        return WorldOrigin(values[0], values[1])
    zone, is_south = utm.zone_of(values[1]), values[0] <= 0.0
    try:
        return WorldOrigin(*utm.utm_of(values[0], values[1], zone, is_south), zone=zone, is_south=is_south)
    except ValueError as error:
        raise FenceError("world_origin: %s" % error)


def _holes(section: Any) -> tuple[FencePrism, ...]:
    if section is None:
        return ()
    if not isinstance(section, dict):
        raise FenceError("safety_area/obstacles is no section")
    if section.get("present", True) is False:
        return ()
    holes: list[FencePrism] = []
    problems: list[str] = []
    for name in sorted(section):
        if name in SETTINGS:
            continue
        hole = _attempt(lambda tree: read_prism("safety_area/obstacles/%s" % name, tree), section[name], problems)
        holes.append(hole)
    count = section.get("count", len(holes))
    if count != len(holes):
        problems.append("safety_area/obstacles/count is %r, but there are %d obstacles" % (count, len(holes)))
    if problems:
        raise FenceError("\n".join(problems))
    return tuple(holes)
