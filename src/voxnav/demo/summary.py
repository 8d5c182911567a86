# SPDX-License-Identifier: BSD-3-Clause
"""The summary of a flight in numbers: ``summary.json`` and the table on the terminal."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from voxnav import evaluation
from voxnav.array_types import Array, ArrayLike
from voxnav.demo.record import FlightRecord


# A simulation this near to its requested speed has kept up with it; the rest is lost while it starts.
_MIN_SPEED_SHARE = 0.98


def path_length(positions: ArrayLike) -> float:
    """Returns the length of a polyline in metres. positions: (n, 3)."""
    rows = np.asarray(positions)
    return float(np.sum(np.linalg.norm(np.diff(rows, axis=0), axis=1))) if len(rows) > 1 else 0.0


def trajectory_error(track: tuple[Array, Array], truth: tuple[Array, Array]) -> float | None:
    """Returns the RMSE of (stamps, positions) against truth after SE(3) alignment; None if it cannot be computed."""
    if len(track[0]) < 3 or len(truth[0]) < 3:
        return None
    try:
        return evaluation.absolute_trajectory_error(track[0], track[1], truth[0], truth[1])
    except evaluation.EvaluationError:
        return None


def fell_behind(record: FlightRecord) -> list[str]:
    """Tells in words what did not keep up with real time; empty if everything did."""
    out = ["%s dropped %d" % item for item in sorted(record.dropped_in_flight.items()) if item[1] > 0]
    if record.real_time_factor is not None and record.real_time_factor < _MIN_SPEED_SHARE * record.speed_factor:
        out.insert(0, "the simulation itself (factor %.2f)" % record.real_time_factor)
    return out


def summarise(record: FlightRecord) -> dict[str, Any]:
    """Returns the fields of summary.json of a voxnav.demo.record.FlightRecord; those not measured are None."""
    flown = record.flown_during_mission()
    return {
        "reached": record.reached,
        "reason": record.reason,
        "min_clearance_m": record.min_clearance_m,
        "has_collided": record.has_collided,
        "num_hovers": record.num_hovers,
        "num_shortened": record.num_shortened,
        "path_length_m": path_length(flown[1]),
        "straight_m": float(np.linalg.norm(flown[1][-1] - flown[1][0])) if len(flown[1]) else None,
        "flight_s": float(flown[0][-1] - flown[0][0]) if len(flown[0]) else None,
        "real_time_factor": record.real_time_factor,
        "ate_odometry_m": trajectory_error(record.until_its_end(record.odometry), record.truth),
        "ate_optimised_m": trajectory_error(record.until_its_end(record.optimised), record.truth),
        "fell_behind": fell_behind(record),
        "stages": record.stages,
        "rss_mb": record.rss_mb,
        "seed": record.seed,
        "world": record.world,
    }


def write_json(path: str, summary: dict[str, Any]) -> None:
    with open(path, "w") as out:
        json.dump(summary, out, indent=2, sort_keys=True)
        out.write("\n")


def _number(value: float | None, pattern: str = "%.2f", unit: str = "") -> str:
    return "not measured" if value is None else pattern % value + unit


def table(summary: dict[str, Any], question: str = "goal reached") -> str:
    """Returns the summary as text for people."""
    lines = ["", "%-23s %s (%s)" % (question, "yes" if summary["reached"] else "NO", summary["reason"]),
             "true minimum clearance  " + _number(summary["min_clearance_m"], unit=" m")]
    if summary["straight_m"]:
        lines.append("path / straight line    %.1f m / %.1f m = %.2f" % (
            summary["path_length_m"], summary["straight_m"], summary["path_length_m"] / summary["straight_m"]))
    lines += ["flight time             " + _number(summary["flight_s"], "%.1f", " s"),
              "real-time factor        " + _number(summary["real_time_factor"]),
              "fell behind             " + (", ".join(summary["fell_behind"]) or "nothing"),
              "trajectory error        odometry %s, optimised %s (RMSE, SE(3)-aligned)" % (
                  _number(summary["ate_odometry_m"], unit=" m"), _number(summary["ate_optimised_m"], unit=" m")),
              "",
              "%-42s %8s %8s %8s %8s %8s %8s" % (
                  "stage", "calls", "mean ms", "p99 ms", "max ms", "cpu ms", "dropped")]
    for name in sorted(summary["stages"]):
        s = summary["stages"][name]
        lines.append("%-42s %8d %8.2f %8.2f %8.2f %8.2f %8d" % (
            name, s["count"], s["mean_ms"], s["p99_ms"], s["max_ms"], s["cpu_ms"], s["dropped"]))
    lines += ["", "%-42s %8s" % ("process of node", "RSS MB")]
    lines += ["%-42s %8.0f" % item for item in sorted(summary["rss_mb"].items())]
    return "\n".join(lines)
