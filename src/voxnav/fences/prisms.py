# SPDX-License-Identifier: BSD-3-Clause
"""Prisms in the frames of those who gave them, and how they are read from YAML."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Sequence

import numpy as np

from voxnav._core import Prism
from voxnav.array_types import Array

# Frames whose coordinates are latitude and longitude [deg], and those of UTM [m].
LATLON, UTM = "latlon_origin", "utm_origin"


class FenceError(ValueError):
    """A fence cannot be used; the text names it and tells why, one problem a line."""


@dataclass(frozen=True, eq=False)
class FencePrism:
    """An upright prism as it was given. points: (n, 2), in degrees of latitude and longitude in the frame LATLON."""

    name: str
    frame: str
    points: Array
    vertical_frame: str
    min_z: float
    max_z: float

    @property
    def problem(self) -> str:
        """Returns why this is no prism, '' if it is one."""
        prism = Prism(np.ascontiguousarray(self.points, dtype=np.float64), self.min_z, self.max_z)
        return str(prism.problem)

    @property
    def is_in_degrees(self) -> bool:
        return short_name(self.frame) == LATLON

    def to_tree(self) -> dict[str, Any]:
        """Returns the prism in the form that read_prism reads."""
        return {"horizontal": {"frame_name": self.frame, "points": [float(x) for x in self.points.ravel()]},
                "vertical": {"frame_name": self.vertical_frame, "min_z": float(self.min_z),
                             "max_z": float(self.max_z)}}


def short_name(frame: str) -> str:
    """Returns the name of a frame without that of the vehicle."""
    return frame.split("/")[-1]


def read_prism(name: str, tree: Any) -> FencePrism:
    """Reads a prism as MRS writes a safety area: sections `horizontal` and `vertical`, each with its frame.

    Raises FenceError that lists every problem.
    """
    problems: list[str] = []
    horizontal, vertical = _section(tree, "horizontal", problems), _section(tree, "vertical", problems)
    frame, vertical_frame = (_frame(part, where, problems) for part, where in (
        (horizontal, "horizontal"), (vertical, "vertical")))
    points = _points(horizontal, problems)
    low, high = (_number(vertical, key, problems) for key in ("min_z", "max_z"))
    if problems:
        raise FenceError("\n".join("%s: %s" % (name, problem) for problem in problems))
    return checked(FencePrism(name, frame, points, vertical_frame, low, high))


def checked(prism: FencePrism) -> FencePrism:
    """Returns a prism that can be used. Raises FenceError for another one."""
    if prism.problem:
        raise FenceError("%s: %s" % (prism.name, prism.problem))
    return prism


def virtual_obstacle(name: str, frame: str, points: Sequence[Sequence[float]]) -> FencePrism:
    """Makes the prism of a virtual obstacle of mrs_octomap_planner: the parallelogram of three points, between the
    lowest and the highest of their heights. points: (3, 3). Raises FenceError."""
    corners = np.asarray(points, dtype=float)
    if corners.shape != (3, 3):
        raise FenceError("%s: a virtual obstacle has exactly 3 points" % name)
    flat = corners[:, :2]
    outline = np.array([flat[0], flat[1], flat[1] + flat[2] - flat[0], flat[2]])
    return checked(FencePrism(name, frame, outline, frame, float(corners[:, 2].min()), float(corners[:, 2].max())))


def _section(tree: Any, key: str, problems: list[str]) -> dict[str, Any]:
    found = tree.get(key) if isinstance(tree, dict) else None
    if isinstance(found, dict):
        return found
    problems.append("section %s is missing" % key if found is None else "%s is no section" % key)
    return {}


def _frame(section: dict[str, Any], where: str, problems: list[str]) -> str:
    if not section:
        return ""
    name = section.get("frame_name")
    if isinstance(name, str) and name:
        return name
    problems.append("%s/frame_name is missing" % where if name is None else
                    "%s/frame_name is %r, not the name of a frame" % (where, name))
    return ""


def _points(section: dict[str, Any], problems: list[str]) -> Array:
    nothing = np.zeros((0, 2))
    if not section:
        return nothing
    given = section.get("points")
    if not isinstance(given, list):
        problems.append("horizontal/points is %s" % ("missing" if given is None else "no list"))
        return nothing
    if any(isinstance(point, list) for point in given):
        if not all(isinstance(point, list) and len(point) == 2 for point in given):
            problems.append("horizontal/points must be a list of numbers, or of pairs of numbers")
            return nothing
        given = [value for point in given for value in point]
    for number, value in enumerate(given):
        if not _is_number(value):
            problems.append("horizontal/points: number %d is %r, not a finite number" % (number + 1, value))
            return nothing
    if len(given) % 2:
        problems.append("horizontal/points: %d numbers are no pairs of x and y" % len(given))
        return nothing
    return np.array(given, dtype=float).reshape(-1, 2)


def _number(section: dict[str, Any], key: str, problems: list[str]) -> float:
    if not section:
        return 0.0
    value: Any = section.get(key)
    if _is_number(value):
        return float(value)
    problems.append("vertical/%s is %s" % (key, "missing" if value is None else "%r, not a finite number" % (value,)))
    return 0.0


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and bool(np.isfinite(value))
