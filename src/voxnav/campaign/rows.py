# SPDX-License-Identifier: BSD-3-Clause
"""A row of ``flights.csv``: what is known of one flight."""

from __future__ import annotations

import csv
import io
from typing import Any, Dict, NamedTuple, Tuple

from voxnav.campaign.grid import FlightTask

Key = Tuple[str, ...]  # cells of world, trees_per_ha, speed_mps, faults and seed


class FlightRow(NamedTuple):
    """A row of flights.csv. What is not known is None, which is an empty cell.

    trees_per_ha, speed_mps (the limit), seed, world and faults say which flight it was. reached is None if the flight
    ended without a result; then reason says how. min_clearance_m: true distance from the vehicle's centre to the
    nearest surface, at its smallest; path_ratio: length of the path over the straight line between its ends;
    hovers, shortened: how often the planner stopped the vehicle, and shortened its trajectory; seconds: simulated
    duration; wall_s: what it took on the machine.
    """

    seed: int
    trees_per_ha: float
    speed_mps: float | None
    reached: bool | None = None
    reason: str = ""
    min_clearance_m: float | None = None
    path_ratio: float | None = None
    mean_speed_mps: float | None = None
    hovers: int | None = None
    shortened: int | None = None
    seconds: float | None = None
    world: str = ""
    faults: bool = False
    collided: bool | None = None
    wall_s: float | None = None

    @property
    def is_success(self) -> bool:
        """Whether it is known that the goal was reached without a collision."""
        return bool(self.reached) and self.collided is False

    @property
    def outcome(self) -> str:
        """A sentence: how the flight ended."""
        collision = "COLLIDED; " if self.collided else ""
        is_silent = self.reached is not None and self.collided is None
        clearance = "" if self.min_clearance_m is None else ", smallest clearance %.2f m" % self.min_clearance_m
        return collision + self.reason + clearance + (", whether it collided is not known" if is_silent else "")

    def __str__(self) -> str:
        speed = "" if self.speed_mps is None else ", up to %g m/s" % self.speed_mps
        faults = ", faults" if self.faults else ""
        return "%s, %g trees/ha%s, seed %d%s" % (self.world, self.trees_per_ha, speed, self.seed, faults)

    @property
    def key(self) -> Key:
        return key_of(self.world, self.trees_per_ha, self.speed_mps, self.faults, self.seed)


def key_of(*cells: object) -> Key:
    return tuple(_text(cell) for cell in cells)


def key_of_task(task: FlightTask) -> Key:
    return key_of(task.world.name, task.world.trees_per_ha, task.speed_mps, task.has_faults, task.seed)


def row_of(task: FlightTask, reason: str, summary: dict[str, Any] | None = None,
           wall_s: float | None = None) -> FlightRow:
    """Returns the row of a flight. summary: the content of its summary.json, or None if it left none."""
    row = FlightRow(seed=task.seed, trees_per_ha=task.world.trees_per_ha, speed_mps=task.speed_mps, reason=reason,
                    world=task.world.name, faults=task.has_faults, wall_s=wall_s)
    if summary is None:
        return row
    length_m, seconds = summary["path_length_m"], summary["flight_s"]
    return row._replace(
        reached=summary["reached"], reason=summary["reason"], min_clearance_m=summary["min_clearance_m"],
        path_ratio=_ratio(length_m, summary["straight_m"]), mean_speed_mps=_ratio(length_m, seconds),
        hovers=summary["num_hovers"], shortened=summary["num_shortened"], seconds=seconds,
        collided=summary["has_collided"])


def _ratio(over: float | None, under: float | None) -> float | None:
    return over / under if over is not None and under else None


def _text(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return "%.6g" % value
    return " ".join(str(value).split())  # a reason stays on one line


def _flag(cell: str) -> bool:
    if cell not in _FLAGS:
        raise ValueError("'%s' is neither true nor false" % cell)
    return _FLAGS[cell]


_FLAGS = {"true": True, "false": False}
_KINDS: Dict[str, Any] = {"seed": int, "reached": _flag, "reason": str, "hovers": int, "shortened": int, "world": str,
                          "faults": _flag, "collided": _flag}
_KEPT_EMPTY = {"reason", "world"}


def line_of(row: FlightRow) -> str:
    return csv_line([_text(value) for value in row])


def csv_line(cells: list[str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(cells)
    return out.getvalue()


def row_from(cells: list[str]) -> FlightRow:
    """Raises ValueError if the cells are not those of a row."""
    if len(cells) != len(FlightRow._fields):
        raise ValueError("%d cells instead of %d" % (len(cells), len(FlightRow._fields)))
    values: dict[str, Any] = {
        name: None if cell == "" and name not in _KEPT_EMPTY else _KINDS.get(name, float)(cell)
        for name, cell in zip(FlightRow._fields, cells)}
    if values["seed"] is None or values["trees_per_ha"] is None or values["faults"] is None:
        raise ValueError("seed, trees_per_ha and faults must be known")
    return FlightRow(**values)
