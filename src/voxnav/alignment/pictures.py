# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of an evaluated flight."""

from __future__ import annotations

from typing import Any

import numpy as np

from voxnav.alignment.flight import SimulatedFlight
from voxnav.alignment.measure import Solved
from voxnav.array_types import Array
from voxnav.evaluation import align_se3
from voxnav.plotting import pyplot


def draw_errors(path: str, title: str, flight: SimulatedFlight, solved: Solved) -> None:
    """Draws the tracks from above, and the error of each axis over time before and after the solve."""
    figure, axes = pyplot().subplots(1, 2, figsize=(13, 5))
    rows = np.searchsorted(flight.stamps_s, solved.stamps_s - 1e-6)
    for T, colour, label in ((flight.T_O_B[rows], "tab:orange", "before"), (solved.T_W_B, "tab:blue", "after")):
        R, t = align_se3(T[:, :3, 3], solved.T_true[:, :3, 3])
        p = T[:, :3, 3] @ R.T + t
        axes[0].plot(p[:, 0], p[:, 1], color=colour, label=label)
        for axis, style in enumerate(("-", "--", ":")):
            axes[1].plot(solved.stamps_s, p[:, axis] - solved.T_true[:, axis, 3], style, color=colour,
                         label="%s, %s" % (label, "xyz"[axis]))
    axes[0].plot(solved.T_true[:, 0, 3], solved.T_true[:, 1, 3], "k--", linewidth=1, label="true")
    axes[0].set(title=title, xlabel="x [m]", ylabel="y [m]", aspect="equal")
    axes[1].set(title="error after SE(3) alignment", xlabel="time [s]", ylabel="error [m]")
    for ax in axes:
        ax.legend(fontsize=8)
        ax.grid(alpha=0.3)
    _save(figure, path)


def draw_trunks(path: str, surfaces: dict[str, Array], world: Any, center: Array, half_width_m: float = 9.0) -> None:
    """Draws from above the surfaces between knee and crown around a place.

    surfaces: dict of title -> (n, 3) aligned points."""
    figure, axes = pyplot().subplots(1, len(surfaces), figsize=(7 * len(surfaces), 7))
    trunks = world.trunks()
    for ax, (title, points) in zip(axes, surfaces.items()):
        height = points[:, 2] - world.ground_height(points[:, 0], points[:, 1])
        near = np.all(np.abs(points[:, :2] - center) < half_width_m, axis=1) & (height > 0.8) & (height < 2.8)
        ax.scatter(points[near, 0], points[near, 1], s=5, color="tab:blue", label="what submaps saw themselves")
        for k in range(len(trunks)):
            share = 1.8 / max(trunks.top[k, 2] - trunks.ground[k, 2], 1.8)
            at = trunks.ground[k, :2] + share * (trunks.top[k] - trunks.ground[k])[:2]
            if np.all(np.abs(at - center) < half_width_m):
                ax.add_patch(pyplot().Circle(at, trunks.radius_ground_m[k], fill=False, color="black"))
        ax.set(title=title, xlabel="x [m]", ylabel="y [m]", aspect="equal",
               xlim=center[0] + half_width_m * np.array([-1, 1]), ylim=center[1] + half_width_m * np.array([-1, 1]))
        ax.legend(loc="upper right", fontsize=8)
    _save(figure, path)


def draw_places(path: str, maps: dict[str, tuple[Array, list[Array]]], world: Any) -> None:
    """Draws the surfaces of maps between knee and crown around some places.

    maps: dict of title -> ((n, 3) aligned points, list of (4, 2) corners of the places)."""
    figure, axes = pyplot().subplots(1, len(maps), figsize=(6 * len(maps), 5), sharex=True, sharey=True,
                                     constrained_layout=True)
    everywhere = np.concatenate([corners for _, places in maps.values() for corners in places])
    low, high = everywhere.min(axis=0) - 6.0, everywhere.max(axis=0) + 6.0
    for ax, (title, (points, places)) in zip(axes, maps.items()):
        height = points[:, 2] - world.ground_height(points[:, 0], points[:, 1])
        near = np.all((points[:, :2] > low) & (points[:, :2] < high), axis=1) & (height > 0.5) & (height < 3.5)
        dots = ax.scatter(points[near, 0], points[near, 1], s=5, c=height[near], cmap="viridis", vmin=0.5, vmax=3.5)
        for corners, colour in zip(places, ("tab:red", "tab:green")):
            ax.add_patch(pyplot().Polygon(corners, fill=False, color=colour))
        ax.set(title=title, xlabel="x [m]", ylabel="y [m]", aspect="equal", xlim=(low[0], high[0]),
               ylim=(low[1], high[1]))
    figure.colorbar(dots, ax=axes, label="height above ground [m]")
    figure.savefig(path, dpi=90)
    pyplot().close(figure)


def _save(figure: Any, path: str) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    pyplot().close(figure)
