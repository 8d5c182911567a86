# SPDX-License-Identifier: BSD-3-Clause
"""Confidence bounds that assume nothing about the distribution, and nothing about the number of flights."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Sequence

import numpy as np

CONFIDENCE = 0.95


class Bounds(NamedTuple):
    """A confidence interval. None: with so few values this side has no bound."""

    low: float | None
    high: float | None


def _scipy_stats() -> Any:
    import scipy.stats  # only people on the ground need it

    return scipy.stats


def share_bounds(num_true: int, num: int, confidence: float = CONFIDENCE) -> Bounds:
    """Returns the interval of a share of which num_true of num are an observation; num 0 has no bounds.

    Exact: the true share lies outside with at most 1 - confidence. Source: Clopper & Pearson 1934.
    """
    if num == 0:
        return Bounds(None, None)
    tail, beta = (1.0 - confidence) / 2.0, _scipy_stats().beta
    low = 0.0 if num_true == 0 else float(beta.ppf(tail, num_true, num - num_true + 1))
    high = 1.0 if num_true == num else float(beta.ppf(1.0 - tail, num_true + 1, num - num_true))
    return Bounds(low, high)


def quantile_bounds(values: Sequence[float], share: float, confidence: float = CONFIDENCE) -> Bounds:
    """Returns the interval of the quantile below which a share of all flights lie. values: (n,), in any order.

    The bounds are values themselves: the number of values below the quantile is binomial, whatever their distribution
    is. Source: Conover, Practical Nonparametric Statistics, 1999, section 3.2.
    """
    ordered, tail = sorted(values), (1.0 - confidence) / 2.0
    # The i-th value, from zero, is above the quantile with the first probability, and at least as high with the second.
    below = _scipy_stats().binom.cdf(np.arange(len(ordered)), len(ordered), share)
    lows, highs = np.flatnonzero(below <= tail), np.flatnonzero(below >= 1.0 - tail)
    return Bounds(ordered[lows[-1]] if len(lows) else None, ordered[highs[0]] if len(highs) else None)


def quantile(values: Sequence[float], share: float) -> float:
    """Returns the smallest value that at least this share of the values do not exceed. Raises ValueError for none."""
    if not values:
        raise ValueError("there is no quantile of no values")
    return sorted(values)[max(0, math.ceil(share * len(values) - 1e-9) - 1)]


def band(num: int, confidence: float = CONFIDENCE) -> float:
    """Returns how far the true distribution function may be from that of num values, everywhere at once.

    Source: the inequality of Dvoretzky, Kiefer and Wolfowitz, with the constant of Massart, Ann. Probab. 1990.
    """
    return min(1.0, math.sqrt(math.log(2.0 / (1.0 - confidence)) / (2.0 * num)))
