# SPDX-License-Identifier: BSD-3-Clause
"""What rain, dust and sunlight leave in the local map, and what filters cost of thin surface: scripts/evaluate_rain."""

from __future__ import annotations

import argparse
from typing import Any, Iterable, NamedTuple

import numpy as np

import voxnav
from voxnav import simulation
from voxnav.array_types import Array
from voxnav.map_quality.flight import fly, path_through
from voxnav.map_quality.surface_cells import KeptShare, SurfaceCells

SCAN_HZ, SCANS_PER_STEP, CHECK_EVERY, NEAR_M, MAX_RANGE_M = 10.0, 3, 5, 12.0, 26.0
SUNLIGHT = 0.0001  # share of false returns in full sun (data sheet of the Ouster OS1)
# Wires, which stand upright here (poles of 1 to 1.4 cm), and twigs of 8 mm.
THIN: dict[str, Any] = dict(
    min_corner_m=[-22.0, -25.0], size_m=[55.0, 50.0], goal_m=[25.0, 0.0], terrain_margin_m=10.0, twigs_per_tree=10,
    twig_radius_m=0.004, bushes_per_ha=150.0, num_poles=60, pole_radius_min_m=0.005, pole_radius_max_m=0.007,
    num_houses=0, num_walls=1)


class Rainy(NamedTuple):
    """False obstacles are occupied voxels within 12 m of the sensor without surface within one voxel: how many appear
    in a minute, and how many there are at a time. shares: what the map keeps, by kind of surface."""

    false_per_minute: float
    false_present: float
    shares: dict[str, KeptShare]


def measure(seed: int, num_scans: int, sensor: dict[str, Any], filter_fields: dict[str, Any],
            resolution_m: float) -> Rainy:
    """Flies at 1 m/s through a forest with thin things. sensor: fields of LidarConfig."""
    world = simulation.World(THIN, seed=seed)
    cloud_filter = voxnav.CloudFilter(voxnav.CloudFilterConfig(**filter_fields))
    local_map = voxnav.LocalMap(voxnav.LocalMapConfig(resolution_m=resolution_m, max_range_m=MAX_RANGE_M))
    things = voxnav.MovingThings()  # as in flight; nothing moves here
    cells = SurfaceCells(world, resolution_m, MAX_RANGE_M)
    poses = np.repeat(path_through(world, -(-num_scans // SCANS_PER_STEP)), SCANS_PER_STEP, axis=0)[:num_scans]
    before: set[tuple[int, ...]] = set()
    appeared, present = 0, []
    for i, scan in enumerate(fly(world, poses, seed, dict(sensor, ghost_ratio=0.0))):
        points_L = np.ascontiguousarray(cloud_filter.apply(scan.organised).points[:, :3])
        local_map.insert(points_L, scan.T_W_L)
        things.update(local_map, i / SCAN_HZ, scan.T_W_L[:3, 3])
        cells.add(scan)
        if i % CHECK_EVERY == CHECK_EVERY - 1:
            now = _false_obstacles(world, local_map, scan.T_W_L[:3, 3], resolution_m)
            appeared += len(now - before)
            present.append(len(now))
            before = now
    return Rainy(appeared * 60.0 * SCAN_HZ / num_scans, float(np.mean(present)), cells.judge(local_map))


def _false_obstacles(world: simulation.World, local_map: voxnav.LocalMap, sensor_W: Array,
                     resolution_m: float) -> set[tuple[int, ...]]:
    centers = local_map.occupied_centers()
    centers = centers[np.linalg.norm(centers - sensor_W, axis=1) < NEAR_M]
    reach_m = 1.5 * resolution_m
    is_false = world.clearance(centers, reach_m) >= reach_m
    return set(map(tuple, np.floor(centers[is_false] / resolution_m).astype(int).tolist()))


def main(arguments: Iterable[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[4], help="seeds of worlds and sensors")
    parser.add_argument("--scans", type=int, default=20, help="scans of each flight")
    parser.add_argument("--rain", type=float, nargs="+", default=[0.0, 2.0, 10.0, 25.0], help="rates in mm/h")
    options = parser.parse_args(None if arguments is None else list(arguments))
    print("Of all surface and of each kind: kept / wrongly free, as shares of the voxels that were seen.\n")
    print("| seed | rain mm/h | m | outliers removed | false / min | present | all | wires | leaves | branches |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for seed in options.seeds:
        for rain in options.rain:
            for is_removing in (False, True):
                for resolution_m in (0.2, 0.4):
                    found = measure(seed, options.scans, {"rain_mm_per_h": rain, "speckle_ratio": SUNLIGHT},
                                    {"remove_outliers": is_removing}, resolution_m)
                    shares = [found.shares[kind] for kind in ("all", "poles", "leaves", "branches")]
                    print("| %d | %g | %.1f | %s | %.0f | %.1f | %s |" % (
                        seed, rain, resolution_m, is_removing, found.false_per_minute, found.false_present,
                        " | ".join("%.3f / %.4f" % (share.kept, share.free) for share in shares)))
    return 0
