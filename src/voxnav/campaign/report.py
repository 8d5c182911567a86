# SPDX-License-Identifier: BSD-3-Clause
"""Writes ``report.html`` of a campaign: success and clearance with confidence bounds, and every failure."""

from __future__ import annotations

import os
from typing import Callable, Sequence

from voxnav.campaign.pictures import clearance_figure, success_figure
from voxnav.campaign.rows import FlightRow
from voxnav.campaign.statistics import CONFIDENCE
from voxnav.campaign.table import (Group, by_density_and_speed, clearance_words, clearances, groups, motion_words,
                                   share_words, stop_words, success_words)
from voxnav.html_report import bullets, head, image, paragraph, png, preformatted, section, table
from voxnav.plotting import PicturesUnavailable

_METHOD = (
    "A success is a flight that reached its goal without a collision; a flight that crashed or hung is none, and its "
    "unknown figures are left out of the others.",
    "Shares have Clopper-Pearson intervals (exact, binomial). Quantiles have intervals from order statistics (for any "
    "distribution); '?' means that there are too few flights for a bound. Bands around distributions are those of "
    "Dvoretzky, Kiefer, Wolfowitz and Massart. All are two-sided at %.0f %%, each for itself." % (100 * CONFIDENCE),
    "Clearance is the true distance from the vehicle's centre to the nearest surface of the world, at its smallest in "
    "a flight. Time is simulated; flights are flown in lock-step, so each can be flown again to the last bit.")

# Returns the command that flies a flight of a row again, and the picture of the flight, or None if there is none.
Replay = Callable[[FlightRow], str]
Picture = Callable[[FlightRow], "bytes | None"]


def summary_lines(rows: Sequence[FlightRow]) -> list[str]:
    """Returns the results in a few sentences."""
    known = [row for row in rows if row.collided is not None]
    num_silent = sum(row.reached is None for row in rows)
    lines = ["reached the goal without a collision: " + success_words(rows),
             "collisions: " + share_words(sum(bool(row.collided) for row in known), len(known))]
    if clearances(rows):
        nearest = min((row for row in rows if row.min_clearance_m is not None),
                      key=lambda row: (row.min_clearance_m, row.key))
        lines += ["smallest clearance: %.2f m (%s)" % (nearest.min_clearance_m or 0.0, nearest),
                  "smallest | 5 %% quantile | median of the clearances of all flights: %s m" % clearance_words(rows)]
    if num_silent:
        lines.append("flights without a result (crashed or hung): %d" % num_silent)
    return lines


def write_report(path: str, rows: Sequence[FlightRow], replay: Replay, picture: Picture) -> None:
    """Writes the page, whole or not at all."""
    parts = [head("Campaign of %d flights" % len(rows)), bullets(summary_lines(rows))]
    for group in groups(rows):
        parts += _group(group)
    parts += _failures([row for row in rows if not row.is_success], replay, picture)
    parts += [section("Method"), bullets(_METHOD)]
    with open(path + ".part", "w") as out:
        out.write("\n".join(parts))
    os.replace(path + ".part", path)


def _group(group: Group) -> list[str]:
    parts = [section("Success: " + group.title), table(*by_density_and_speed(group, success_words)),
             _figure(success_figure, group),
             section("Clearance: " + group.title),
             paragraph("Smallest | 5 % quantile | median of the flights of a cell, in metres, with bounds:"),
             table(*by_density_and_speed(group, clearance_words)), _figure(clearance_figure, group),
             section("Motion: " + group.title),
             paragraph("Medians of the mean speed, and of the path's length over the straight line:"),
             table(*by_density_and_speed(group, motion_words)),
             paragraph("Hovers and shortened trajectories per flight:"),
             table(*by_density_and_speed(group, stop_words))]
    return parts


def _figure(draw: Callable[[Group], object], group: Group) -> str:
    try:
        return image(draw(group))
    except PicturesUnavailable as error:
        return paragraph(str(error))


def _failures(rows: Sequence[FlightRow], replay: Replay, picture: Picture) -> list[str]:
    parts = [section("Failures: %d" % len(rows))]
    for row in sorted(rows, key=lambda row: row.key):
        data = picture(row)
        parts += [paragraph("%s: %s" % (row, row.outcome)), preformatted(replay(row)),
                  paragraph("There is no picture of this flight.") if data is None else png(data)]
    return parts
