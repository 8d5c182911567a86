# SPDX-License-Identifier: BSD-3-Clause
"""Writes ``report.html``, a single file that contains its pictures, so that it can be sent to somebody."""

from __future__ import annotations

from typing import Any

import numpy as np

from voxnav.array_types import Array
from voxnav.html_report import bullets, head, image, paragraph, preformatted, section, table
from voxnav.plotting import pyplot


def map_figure(occupied: Array, odometry: Array, optimised: Array, reference: Array | None = None) -> Any:
    """Draws the map from above, coloured by height, with the trajectories. occupied: (n, 3) metres."""
    figure, axes = pyplot().subplots(figsize=(12, 8))
    if len(occupied):
        points = occupied[np.argsort(occupied[:, 2])]
        low, high = np.percentile(points[:, 2], [2, 98])
        image = axes.scatter(points[:, 0], points[:, 1], c=points[:, 2], s=1.5, cmap="viridis", vmin=low,
                             vmax=max(high, low + 1e-3), linewidths=0)
        figure.colorbar(image, ax=axes, label="height [m]", shrink=0.7)
    for track, colour, label in ((odometry, "tab:orange", "odometry"), (optimised, "tab:red", "optimised"),
                                 (reference, "black", "reference")):
        if track is not None and len(track):
            axes.plot(track[:, 0], track[:, 1], color=colour, linewidth=1.5, label=label)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(loc="best")
    return figure


def stage_figure(stages: dict[str, Any]) -> Any:
    """Draws mean and p99 of every stage."""
    names = sorted(stages)
    figure, axes = pyplot().subplots(figsize=(10, 0.5 * len(names) + 1.5))
    rows = np.arange(len(names))
    axes.barh(rows + 0.2, [stages[n]["mean_ms"] for n in names], height=0.4, label="mean")
    axes.barh(rows - 0.2, [stages[n]["p99_ms"] for n in names], height=0.4, label="p99")
    axes.set_yticks(rows)
    axes.set_yticklabels(names)
    axes.set_xlabel("time per call [ms]")
    axes.set_xscale("symlog", linthresh=1.0)
    axes.grid(axis="x", alpha=0.3)
    axes.legend()
    return figure


def memory_figure(memory: list[dict[str, float]]) -> Any:
    """Draws memory over time. memory: list of dicts with time_s and *_mb."""
    figure, axes = pyplot().subplots(figsize=(10, 3.5))
    times = [row["time_s"] for row in memory]
    for key in sorted(memory[0]):
        if key.endswith("_mb"):
            axes.plot(times, [row[key] for row in memory], label=key[:-3].replace("_", " "))
    axes.set_xlabel("time in the recording [s]")
    axes.set_ylabel("MB")
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


def write_report(path: str, title: str, metrics: dict[str, Any], occupied: Array, odometry: Array, optimised: Array,
                 reference: Array | None = None) -> None:
    """Writes the report. metrics: the content of metrics.json."""
    stages = metrics["stages"]
    columns = ("count", "mean_ms", "median_ms", "p99_ms", "max_ms", "cpu_ms", "dropped")
    rows = [[name] + ["%.2f" % s[c] if isinstance(s[c], float) else s[c] for c in columns]
            for name, s in sorted(stages.items())]
    counts = [[key, value] for key, value in sorted(metrics["counts"].items())]
    errors = [[key, "%.3f m" % value] for key, value in sorted(metrics.get("errors", {}).items())]
    parts = [head(title), paragraph(metrics["coverage"]["sentence"])]
    if metrics["recording"]:
        parts += [section("The recording"), preformatted("\n".join(metrics["recording"]))]
    parts += [section("Map and trajectory"), image(map_figure(occupied, odometry, optimised, reference))]
    if errors:
        parts += [section("Trajectory error"), table(errors, ("RMSE", "value"))]
    parts += [section("Time of every stage"), table(rows, ("stage",) + columns)]
    if stages:
        parts.append(image(stage_figure(stages)))
    if metrics["memory"]:
        parts += [section("Memory"), image(memory_figure(metrics["memory"]))]
    parts += [section("Counts"), table(counts, ("what", "number"))]
    parts += [section("What was left out"), bullets(metrics["left_out_lines"] or ["nothing"])]
    warnings = [warning for warning in metrics["warnings"] if warning not in metrics["left_out_lines"]]
    if warnings:
        parts += [section("Warnings"), bullets(warnings)]
    with open(path, "w") as out:
        out.write("\n".join(parts))
