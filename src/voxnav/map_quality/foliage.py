# SPDX-License-Identifier: BSD-3-Clause
"""What the local map keeps of a forest that is seen by beams with width: scripts/evaluate_foliage."""

from __future__ import annotations

import argparse
from typing import Any, Iterable

import numpy as np

import voxnav
from voxnav import simulation
from voxnav.map_quality.flight import SCAN_HZ, WIDE_BEAM, fly, path_through
from voxnav.map_quality.surface_cells import KeptShare, SurfaceCells

RESOLUTIONS_M, MAX_RANGE_M = (0.2, 0.4), 26.0
# As worlds/thicket.yaml, on less ground and with more bushes and poles, which would be too few for statistics.
THICKET: dict[str, Any] = dict(
    min_corner_m=[-22.0, -25.0], size_m=[55.0, 50.0], goal_m=[25.0, 0.0], terrain_margin_m=10.0,
    leaves_per_tree=4000, leaf_size_m=0.12, twigs_per_tree=80, leaves_per_bush=900, bushes_per_ha=150.0,
    num_poles=20, num_houses=0, num_walls=1)


def measure(seed: int, num_scans: int, sensor: dict[str, Any], world_config: dict[str, Any] | str | None = None,
            cloud_filter: voxnav.CloudFilter | None = None) -> dict[float, tuple[dict[str, KeptShare], float]]:
    """Flies through a thicket. Returns for each resolution the shares of kept surface by its kind, and the share of
    occupied voxels without surface within one voxel.

    world_config: another world, as simulation.World takes it. cloud_filter: None stands for one that removes false
    returns and nothing else.
    """
    world = simulation.World(THICKET if world_config is None else world_config, seed=seed)
    maps = {r: voxnav.LocalMap(voxnav.LocalMapConfig(resolution_m=r, max_range_m=MAX_RANGE_M)) for r in RESOLUTIONS_M}
    things = {r: voxnav.MovingThings() for r in RESOLUTIONS_M}  # as in flight; nothing moves here
    cells = {r: SurfaceCells(world, r, MAX_RANGE_M) for r in RESOLUTIONS_M}
    poses, fields = path_through(world, num_scans), dict(WIDE_BEAM, ghost_ratio=0.0, **sensor)
    for i, scan in enumerate(fly(world, poses, seed, fields)):
        points_L = scan.points_L()
        if cloud_filter is not None:
            points_L = np.ascontiguousarray(cloud_filter.apply(scan.organised).points[:, :3])
        for r in RESOLUTIONS_M:
            maps[r].insert(points_L, scan.T_W_L)
            things[r].update(maps[r], i / SCAN_HZ, scan.T_W_L[:3, 3])
            cells[r].add(scan)
    return {r: (cells[r].judge(maps[r]), _phantoms(world, maps[r], r)) for r in RESOLUTIONS_M}


def _phantoms(world: simulation.World, local_map: voxnav.LocalMap, resolution_m: float) -> float:
    reach_m = 1.5 * resolution_m
    return float(np.mean(world.clearance(local_map.occupied_centers(), reach_m) >= reach_m))


def print_rows(seed: int, resolution_m: float, shares: dict[str, KeptShare], phantoms: float) -> None:
    for kind, s in shares.items():
        print("| %d | %.1f | %s | %d | %.3f | %.3f | %.3f | %.4f | |" % (
            seed, resolution_m, kind, s.voxels, s.kept, s.free, s.returned, s.kept_of_returned))
    print("| %d | %.1f | occupied | | | | | | %.4f |" % (seed, resolution_m, phantoms))


def main(arguments: Iterable[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3], help="seeds of worlds and sensors")
    parser.add_argument("--scans", type=int, default=20, help="scans of each flight")
    parser.add_argument("--columns", type=int, default=1024, help="columns of a scan")
    options = parser.parse_args(None if arguments is None else list(arguments))
    print("| seed | m | surface | voxels | kept | wrongly free | any return | kept of these | phantoms |")
    print("|---|---|---|---|---|---|---|---|---|")
    for seed in options.seeds:
        for resolution_m, found in measure(seed, options.scans, {"columns": options.columns}).items():
            print_rows(seed, resolution_m, *found)
    return 0
