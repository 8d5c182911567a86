# SPDX-License-Identifier: BSD-3-Clause
"""Rain and sunlight with the default filter and map: few false obstacles, and thin things stay."""

import pytest

pytest.importorskip("voxnav._simulation", reason="built without Embree")
from voxnav.map_quality.rain import SUNLIGHT, measure  # noqa: E402

HEAVY_RAIN = {"rain_mm_per_h": 10.0, "speckle_ratio": SUNLIGHT}


@pytest.mark.parametrize("resolution_m,most_per_minute", [(0.2, 150), (0.4, 600)])
def test_heavy_rain_hardly_becomes_obstacles_and_thin_things_stay(resolution_m, most_per_minute):
    by_default = measure(4, 20, HEAVY_RAIN, {}, resolution_m)
    unfiltered = measure(4, 20, HEAVY_RAIN, {"remove_outliers": False}, resolution_m)
    print(resolution_m, by_default, unfiltered)
    assert by_default.false_per_minute <= most_per_minute
    assert unfiltered.false_per_minute > 4 * most_per_minute, "this rain is no trouble"
    assert by_default.false_present < 0.1 * unfiltered.false_present
    for kind in ("poles", "branches", "leaves"):
        assert by_default.shares[kind].kept > unfiltered.shares[kind].kept - 0.02, kind
        # A return that the filter removes does not protect its voxel from beams that pass beside.
        assert by_default.shares[kind].free < unfiltered.shares[kind].free + 0.012, kind
    assert by_default.shares["poles"].kept >= 0.95 and by_default.shares["branches"].kept >= 0.97


def test_dry_air_has_no_false_obstacles():
    assert measure(4, 10, {}, {}, 0.4).false_per_minute == 0.0
