# SPDX-License-Identifier: BSD-3-Clause
"""The results of a campaign as tables: groups of flights by world and faults, and cells by density and speed."""

from __future__ import annotations

from typing import Callable, NamedTuple, Sequence

from voxnav.campaign.rows import FlightRow
from voxnav.campaign.statistics import quantile, quantile_bounds, share_bounds

Cell = Callable[[Sequence[FlightRow]], str]


class Group(NamedTuple):
    """Flights in one world, all with faults or all without."""

    world: str
    has_faults: bool
    rows: list[FlightRow]

    @property
    def title(self) -> str:
        return "%s, faults %s" % (self.world, "on" if self.has_faults else "off")


def groups(rows: Sequence[FlightRow]) -> list[Group]:
    kinds = sorted({(row.world, row.faults) for row in rows})
    return [Group(world, faults, [row for row in rows if (row.world, row.faults) == (world, faults)])
            for world, faults in kinds]


def densities(rows: Sequence[FlightRow]) -> list[float]:
    return sorted({row.trees_per_ha for row in rows})


def speeds(rows: Sequence[FlightRow]) -> list[float | None]:
    return sorted({row.speed_mps for row in rows}, key=lambda speed: -1.0 if speed is None else speed)


def speed_words(speed_mps: float | None) -> str:
    return "speed as configured" if speed_mps is None else "up to %g m/s" % speed_mps


def in_cell(rows: Sequence[FlightRow], trees_per_ha: float, speed_mps: float | None) -> list[FlightRow]:
    return [row for row in rows if row.trees_per_ha == trees_per_ha and row.speed_mps == speed_mps]


def clearances(rows: Sequence[FlightRow]) -> list[float]:
    """Returns the known clearances; those of flights without a result are not known."""
    return [row.min_clearance_m for row in rows if row.min_clearance_m is not None]


def by_density_and_speed(group: Group, cell: Cell) -> tuple[list[list[str]], list[str]]:
    """Returns (rows, header) of a table. cell: turns the flights of a cell, which are not none, into its text."""
    columns = speeds(group.rows)
    out = []
    for density in densities(group.rows):
        flights = [in_cell(group.rows, density, speed_mps) for speed_mps in columns]
        out.append(["%g" % density] + [cell(rows) if rows else "-" for rows in flights])
    return out, ["trees per hectare"] + [speed_words(speed_mps) for speed_mps in columns]


def share_words(num_true: int, num: int) -> str:
    bounds = share_bounds(num_true, num)
    if bounds.low is None or bounds.high is None:
        return "none"
    return "%d of %d = %.0f %% (%.0f to %.0f)" % (
        num_true, num, 100.0 * num_true / num, 100.0 * bounds.low, 100.0 * bounds.high)


def success_words(rows: Sequence[FlightRow]) -> str:
    return share_words(sum(row.is_success for row in rows), len(rows))


def clearance_words(rows: Sequence[FlightRow]) -> str:
    """Returns smallest, 5 % quantile and median with their bounds."""
    values = clearances(rows)
    if not values:
        return "not measured"
    return "%.2f | %s | %s" % (min(values), _quantile_words(values, 0.05), _quantile_words(values, 0.5))


def _quantile_words(values: Sequence[float], share: float) -> str:
    bounds = quantile_bounds(values, share)
    low, high = ("?" if bound is None else "%.2f" % bound for bound in bounds)
    return "%.2f (%s to %s)" % (quantile(values, share), low, high)


def motion_words(rows: Sequence[FlightRow]) -> str:
    """Returns the medians of mean speed and of the path's ratio, over the flights in which they are known."""
    mean_speeds = [row.mean_speed_mps for row in rows if row.mean_speed_mps is not None]
    ratios = [row.path_ratio for row in rows if row.path_ratio is not None]
    if not mean_speeds or not ratios:
        return "not measured"
    return "%.2f m/s, %.3f" % (quantile(mean_speeds, 0.5), quantile(ratios, 0.5))


def stop_words(rows: Sequence[FlightRow]) -> str:
    """Returns how many hovers and shortened trajectories there were per flight, where they are known."""
    known = [(row.hovers, row.shortened) for row in rows if row.hovers is not None and row.shortened is not None]
    if not known:
        return "not measured"
    return "%.2f, %.2f" % (sum(hovers for hovers, _ in known) / len(known),
                           sum(shortened for _, shortened in known) / len(known))
