# SPDX-License-Identifier: BSD-3-Clause
"""The figures of a campaign's report."""

from __future__ import annotations

from typing import Any, NamedTuple, Sequence

import numpy as np

from voxnav.array_types import Array
from voxnav.campaign.statistics import band, share_bounds
from voxnav.campaign.table import Group, clearances, densities, in_cell, speed_words, speeds
from voxnav.plotting import pyplot

_COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red", "tab:purple", "tab:brown", "tab:pink", "tab:olive")


def success_figure(group: Group) -> Any:
    """Draws the share of flights that reached their goal over density, one line per speed, with confidence bounds."""
    figure, axes = pyplot().subplots(figsize=(9, 4))
    at, columns = np.arange(len(densities(group.rows))), speeds(group.rows)
    for column, speed_mps in enumerate(columns):
        cells = [in_cell(group.rows, density, speed_mps) for density in densities(group.rows)]
        known = [(x, sum(row.is_success for row in cell), len(cell)) for x, cell in zip(at, cells) if cell]
        shares = np.array([num_true / num for _, num_true, num in known])
        bounds = np.array([share_bounds(num_true, num) for _, num_true, num in known], dtype=float)
        x = np.array([x for x, _, _ in known]) + 0.12 * (column - (len(columns) - 1) / 2.0)
        axes.errorbar(x, shares, np.abs(bounds.T - shares), fmt="o", capsize=4, color=_colour(column),
                      label=speed_words(speed_mps))
    axes.set_xticks(at)
    axes.set_xticklabels(["%g" % density for density in densities(group.rows)])
    axes.set(xlabel="trees per hectare", ylabel="share of successes", ylim=(-0.03, 1.03), title=group.title)
    axes.grid(alpha=0.3)
    axes.set_xlim(-0.5, len(at) - 0.5)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure


def clearance_figure(group: Group) -> Any:
    """Draws the distribution of the smallest clearance of flights, one panel per speed, one line per density."""
    columns, end_m = speeds(group.rows), 1.05 * max(clearances(group.rows), default=1.0)
    figure, panels = pyplot().subplots(1, len(columns), figsize=(max(6.0, 4.0 * len(columns)), 4), sharey=True,
                                       sharex=True, squeeze=False, constrained_layout=True)
    for axes, speed_mps in zip(panels[0], columns):
        for line, density in enumerate(densities(group.rows)):
            values = clearances(in_cell(group.rows, density, speed_mps))
            if values:
                steps = _distribution(values, end_m)
                axes.step(steps.x, steps.share, where="post", color=_colour(line),
                          label="%g trees/ha (%d)" % (density, len(values)))
                axes.fill_between(steps.x, steps.low, steps.high, step="post", color=_colour(line), alpha=0.1)
        axes.set(xlabel="smallest clearance of a flight [m]", title=speed_words(speed_mps), xlim=(0.0, end_m),
                 ylim=(-0.03, 1.03))
        axes.grid(alpha=0.3)
    panels[0, 0].set_ylabel("share of flights below")
    if panels[0, 0].get_legend_handles_labels()[0]:
        panels[0, 0].legend(fontsize=8, loc="upper left")
    return figure


class _Steps(NamedTuple):
    """A distribution function between steps at x, with its confidence band."""

    x: Array
    share: Array
    low: Array
    high: Array


def _distribution(values: Sequence[float], end_m: float) -> _Steps:
    """Returns the distribution of the values from 0 to end_m. Below the smallest value the band is not empty either."""
    share, half = np.arange(len(values) + 1) / len(values), band(len(values))
    share = np.r_[share, 1.0]
    return _Steps(np.r_[0.0, np.sort(values), end_m], share, np.clip(share - half, 0.0, 1.0),
                  np.clip(share + half, 0.0, 1.0))


def _colour(index: int) -> str:
    return _COLOURS[index % len(_COLOURS)]
