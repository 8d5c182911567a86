# SPDX-License-Identifier: BSD-3-Clause
"""Voxels that hold surface which was seen, and what a map makes of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import voxnav
from voxnav import simulation
from voxnav.array_types import Array
from voxnav.map_quality.flight import AimedScan

LEAST_SCANS = 5  # a surface that was seen less often is nobody's fault
BUSH_HEIGHT_M = 2.0  # foliage below belongs to bushes, crowns begin higher
OCCUPIED_ABOVE, FREE = 0.5, 1
KIND_OF = {"terrain": "ground", "rock": "ground", "building": "ground", "vehicle": "ground", "trunk": "trunks",
           "pole": "poles", "foliage": "leaves", "branch": "branches"}
KINDS = ("ground", "trunks", "poles", "leaves", "bushes", "branches")


class KeptShare(NamedTuple):
    """How many voxels hold a kind of surface, and the shares of them that are kept (p > 0.5), that are wrongly free,
    and in which any return fell. kept_of_returned: share of the latter that is kept."""

    voxels: int
    kept: float
    free: float
    returned: float
    kept_of_returned: float


class SurfaceCells:
    """Counts over a flight in how many scans beams were aimed at the surface in each voxel."""

    def __init__(self, world: simulation.World, resolution_m: float, max_range_m: float) -> None:
        self._world, self._resolution_m, self._max_range_m = world, resolution_m, max_range_m
        self._seen: list[Array] = []  # per scan (k, 4): voxel and kind
        self._returns: list[Array] = []  # per scan (k,): keys of voxels

    def _kinds(self, points_W: Array, classes: Array) -> Array:
        table = np.zeros(max(simulation.CLASSES.values()) + 1, int)
        for name, kind in KIND_OF.items():
            table[simulation.CLASSES[name]] = KINDS.index(kind)
        kinds = table[classes]
        height = points_W[:, 2] - self._world.ground_height(points_W[:, 0], points_W[:, 1])
        kinds[(kinds == KINDS.index("leaves")) & (height < BUSH_HEIGHT_M)] = KINDS.index("bushes")
        return kinds

    def add(self, scan: AimedScan) -> None:
        """Counts a scan. Only surface within the range of the map counts."""
        near = np.linalg.norm(scan.surface_W - scan.T_W_L[:3, 3], axis=1) < self._max_range_m
        points, classes = scan.surface_W[near], scan.classes[near]
        voxels, first = np.unique(self._voxels(points), axis=0, return_index=True)
        self._seen.append(np.column_stack([voxels, self._kinds(points[first], classes[first])]))
        returns_L = scan.points_L()
        returns_L = returns_L[np.linalg.norm(returns_L, axis=1) < self._max_range_m]
        self._returns.append(np.unique(_keys(self._voxels(returns_L @ scan.T_W_L[:3, :3].T + scan.T_W_L[:3, 3]))))

    def judge(self, local_map: voxnav.LocalMap) -> dict[str, KeptShare]:
        """Returns the shares of all voxels aimed at in at least LEAST_SCANS scans, and of each kind of surface."""
        seen = np.concatenate(self._seen)
        voxels, first, scans = np.unique(seen[:, :3], axis=0, return_index=True, return_counts=True)
        often = scans >= LEAST_SCANS
        voxels, kinds = voxels[often], seen[first[often], 3]
        states = local_map.states(((voxels + 0.5) * self._resolution_m).astype(np.float32))
        kept = np.isin(_keys(voxels), _keys(self._voxels(local_map.occupied_centers(OCCUPIED_ABOVE))))
        returned = np.isin(_keys(voxels), np.concatenate(self._returns))
        out = {"all": _share(kept, states == FREE, returned)}
        for kind, name in enumerate(KINDS):
            of = kinds == kind
            if of.any():
                out[name] = _share(kept[of], states[of] == FREE, returned[of])
        return out

    def _voxels(self, points_W: Array) -> Array:
        voxels: Array = np.floor(points_W / self._resolution_m).astype(int)
        return voxels


def _share(kept: Array, free: Array, returned: Array) -> KeptShare:
    of_returned = kept[returned].mean() if returned.any() else 1.0
    return KeptShare(len(kept), float(kept.mean()), float(free.mean()), float(returned.mean()), float(of_returned))


def _keys(voxels: Array) -> Array:
    """Returns one number for each voxel, (n,) int64."""
    v = voxels.astype(np.int64) + 50000
    keys: Array = v[:, 0] * 10 ** 10 + v[:, 1] * 10 ** 5 + v[:, 2]
    return keys
