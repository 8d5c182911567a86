# SPDX-License-Identifier: BSD-3-Clause
"""Foliage as a LiDAR with wide beams sees it, from which returns are mixed: the local map keeps what returned."""

import os

import pytest

pytest.importorskip("voxnav._simulation", reason="built without Embree")
import voxnav  # noqa: E402
from voxnav.map_quality.foliage import measure  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
NUM_SCANS, COLUMNS = 16, 512


@pytest.mark.parametrize("seed", [4, 5, 6])
def test_surface_of_a_thicket_is_kept(seed):
    found = measure(seed, NUM_SCANS, {"columns": COLUMNS})
    for resolution_m, (shares, phantoms) in found.items():
        print(seed, resolution_m, "phantoms %.4f" % phantoms,
              {kind: "%d %.3f/%.3f %.3f %.4f" % s for kind, s in shares.items()})
        everything = shares["all"]
        assert everything.voxels > 10000
        assert everything.kept >= 0.97 and everything.free <= 0.02
        # In the other voxels no return ever fell: the echoes of leaves that follow closely lie between them.
        assert everything.kept_of_returned >= 0.995
        assert shares["leaves"].returned < 0.99, "the beams are too narrow for a test of foliage"
        for kind in ("ground", "trunks", "leaves"):
            assert shares[kind].kept >= 0.95, kind
        assert phantoms <= 0.001


def test_the_shipped_thicket_is_kept_behind_the_shipped_filter():
    world = os.path.join(ROOT, "worlds", "thicket.yaml")
    found = measure(1, 10, {"columns": COLUMNS}, world, voxnav.CloudFilter())
    for resolution_m, (shares, phantoms) in found.items():
        print(resolution_m, "phantoms %.4f" % phantoms,
              {kind: "%d %.3f/%.3f %.3f %.4f" % s for kind, s in shares.items()})
        assert shares["all"].voxels > 5000
        assert shares["all"].kept >= 0.98 and shares["all"].free <= 0.01 and phantoms <= 0.001
        assert shares["all"].kept_of_returned >= 0.995
        for kind, share in shares.items():
            assert share.kept >= 0.95 and share.free <= 0.02, kind
