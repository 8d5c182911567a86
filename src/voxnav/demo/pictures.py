# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of a flight."""

from __future__ import annotations

from typing import Any

import numpy as np

from voxnav.array_types import Array
from voxnav.demo.record import FlightRecord
from voxnav.plotting import pyplot

# Only things in this range of heights around the flight are drawn: ground and canopy would cover the picture.
_SURFACE_BAND_M, _OBSTACLE_BAND_M = 1.2, 0.4


def _near_level(points: Array, level_m: float, band_m: float) -> Array:
    near: Array = points[np.abs(points[:, 2] - level_m) < band_m] if len(points) else points
    return near


def _scatter_heights(figure: Any, axes: Any, points: Array, size: float) -> None:
    order = np.argsort(points[:, 2])
    image = axes.scatter(points[order, 0], points[order, 1], c=points[order, 2], s=size, cmap="viridis", linewidths=0,
                         rasterized=True, label="surfaces near flight level", zorder=2)
    figure.colorbar(image, ax=axes, label="height [m]", shrink=0.7)


def _draw_tracks(axes: Any, record: FlightRecord) -> None:
    for track, colour, style, label in ((record.odometry, "tab:orange", "-", "odometry"),
                                        (record.optimised, "tab:blue", "-", "optimised"),
                                        (record.truth, "black", "--", "true path")):
        if len(track[0]):
            axes.plot(track[1][:, 0], track[1][:, 1], style, color=colour, linewidth=1.5, label=label, zorder=4)
    if record.goal is not None:
        axes.plot(record.goal[0], record.goal[1], "r*", markersize=16, label="goal", zorder=5)


def _flight_level(record: FlightRecord) -> float | None:
    flown = record.flown_during_mission()[1]
    return float(np.median(flown[:, 2])) if len(flown) else None


def top_view(path: str, record: FlightRecord, trunks: Array | None = None) -> None:
    """Draws map, obstacles and path from above.

    trunks: (n, 3) x y radius in metres of the simulated world's trunks, drawn as truth, or None.
    """
    figure, axes = pyplot().subplots(figsize=(14, 8))
    level_m = _flight_level(record)
    obstacles, surface = record.obstacle_points, record.surface_points
    if level_m is not None:
        obstacles = _near_level(obstacles, level_m, _OBSTACLE_BAND_M)
        surface = _near_level(surface, level_m, _SURFACE_BAND_M)
    if len(obstacles):
        axes.scatter(obstacles[:, 0], obstacles[:, 1], color="0.88", s=9.0, linewidths=0, rasterized=True,
                     label="too near to something", zorder=1)
    if len(surface):
        _scatter_heights(figure, axes, surface, 4.0)
    if trunks is not None:
        for x, y, radius in trunks:
            axes.add_patch(pyplot().Circle((x, y), max(radius, 0.15), edgecolor="red", facecolor="none", zorder=3))
        axes.plot([], [], "o", markeredgecolor="red", markerfacecolor="none", label="true trunks")
    _draw_tracks(axes, record)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_title("%s: %s" % (record.title, record.reason))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", fontsize=8)
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=110, bbox_inches="tight")
    pyplot().close(figure)
