# SPDX-License-Identifier: BSD-3-Clause
"""Confidence bounds agree with known values and with what defines them."""

import math

import numpy as np
import pytest

from voxnav.campaign.statistics import band, quantile, quantile_bounds, share_bounds


def at_most(k, n, p):
    """Returns the probability that a binomial count is at most k, by its sum."""
    return sum(math.comb(n, i) * p ** i * (1.0 - p) ** (n - i) for i in range(k + 1))


@pytest.mark.parametrize("num_true,num,low,high", [
    (0, 10, 0.0, 0.3085), (10, 10, 0.6915, 1.0), (8, 10, 0.4439, 0.9748), (95, 100, 0.8872, 0.9836),
    (0, 100, 0.0, 0.0362)])
def test_known_intervals_of_clopper_and_pearson(num_true, num, low, high):
    assert share_bounds(num_true, num) == pytest.approx((low, high), abs=1e-4)


@pytest.mark.parametrize("num", [1, 7, 40])
def test_the_bounds_of_a_share_are_where_the_observation_becomes_unlikely(num):
    for num_true in range(num + 1):
        low, high = share_bounds(num_true, num)
        if num_true > 0:
            assert 1.0 - at_most(num_true - 1, num, low) == pytest.approx(0.025)
        if num_true < num:
            assert at_most(num_true, num, high) == pytest.approx(0.025)
        assert low <= num_true / num <= high


def test_no_flights_have_no_bounds():
    assert share_bounds(0, 0) == (None, None)
    assert quantile_bounds([], 0.5) == (None, None)
    with pytest.raises(ValueError):
        quantile([], 0.5)


def test_known_interval_of_a_median():
    values = [float(i) for i in range(20, 0, -1)]
    assert quantile_bounds(values, 0.5) == (6.0, 15.0)  # 95.9 %, as in tables of the sign test


def test_few_flights_have_no_lower_bound_of_a_low_quantile():
    low, high = quantile_bounds([1.0, 1.1, 1.2, 1.3, 1.4], 0.05)
    assert low is None and high == 1.1


@pytest.mark.parametrize("num,share", [(6, 0.5), (30, 0.05), (75, 0.05), (100, 0.9)])
def test_bounds_of_quantiles_are_exact_and_as_near_as_they_can_be(num, share):
    low, high = quantile_bounds(np.arange(1.0, num + 1.0), share)
    if low is not None:  # the low-th value is above the quantile if fewer than that many values are below it
        assert at_most(int(low) - 1, num, share) <= 0.025 < at_most(int(low), num, share)
    if high is not None:
        assert 1.0 - at_most(int(high) - 1, num, share) <= 0.025 < 1.0 - at_most(int(high) - 2, num, share)


def test_bounds_cover_the_quantile_as_often_as_they_say():
    random = np.random.RandomState(1)
    covered = 0
    for values in random.exponential(size=(400, 50)):
        low, high = quantile_bounds(values, 0.5)
        covered += low <= math.log(2.0) <= high
    assert covered >= 0.93 * 400


def test_quantiles_are_values():
    values = [3.0, 1.0, 2.0, 4.0]
    assert [quantile(values, share) for share in (0.0, 0.25, 0.26, 0.5, 1.0)] == [1.0, 1.0, 2.0, 2.0, 4.0]


def test_known_band():
    assert band(100) == pytest.approx(0.1358, abs=1e-4)
    assert band(1) == 1.0
