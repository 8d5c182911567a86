# SPDX-License-Identifier: BSD-3-Clause
"""A flight brakes in the first sweep that shows a truck before it, and loses no way that it has to stop."""

import pytest

from voxnav import reaction

CORRIDOR_M, MARGIN_M = 0.7, 0.4


@pytest.mark.parametrize("gap_m,speed_mps", [(8.0, 3.0), (5.0, 3.0), (8.0, 5.0), (4.0, 2.0)])
def test_the_first_sweep_that_shows_a_truck_stops_the_flight(gap_m, speed_mps):
    now, before = reaction.fly(gap_m, speed_mps), reaction.fly(gap_m, speed_mps, use_new_hits=False)
    print(now, before)
    assert now.sweeps == 1
    # Where there is more room than the flight needs, it rests the margin before its corridor ends.
    assert now.clearance_m > min(now.best_m, CORRIDOR_M + MARGIN_M) - 0.05
    assert before.sweeps > 1, "the test shows nothing"
    assert now.clearance_m >= before.clearance_m
