# SPDX-License-Identifier: BSD-3-Clause
"""``scripts/merge_maps``: merges two saved maps; where they overlap, the later flight is the newer evidence."""

from __future__ import annotations

import argparse
import sys
from typing import Sequence

import numpy as np

import voxnav
from voxnav.array_types import Array


def pose_from(x_y_z_yaw: Sequence[float]) -> Array:
    """Returns the (4, 4) pose of (4,) x, y, z in metres and yaw in radians."""
    x, y, z, yaw = x_y_z_yaw
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T[:3, 3] = x, y, z
    return T


def merge(first: str, second: str, T_W_other: Array) -> tuple[voxnav.SubmapCollection, list[str]]:
    """Loads two map folders and adds the second as the newer one. Returns (SubmapCollection, what was left out)."""
    merged, problems = voxnav.SubmapCollection.load(first, recover=True)
    other, more = voxnav.SubmapCollection.load(second, recover=True)
    merged.merge(other, T_W_other)
    return merged, problems + more


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="merge_maps", description=__doc__)
    parser.add_argument("first", help="folder of a saved map")
    parser.add_argument("second", help="folder of the map of a later flight")
    parser.add_argument("out", help="folder for the map of both")
    parser.add_argument("--pose", nargs=4, type=float, default=[0.0, 0.0, 0.0, 0.0], metavar=("X", "Y", "Z", "YAW"),
                        help="of the second map's frame in the first's, metres and radians (default: the same frame)")
    options = parser.parse_args(argv)
    try:
        merged, problems = merge(options.first, options.second, pose_from(options.pose))
        merged.save(options.out)
    except (OSError, RuntimeError, ValueError) as error:
        print("merge_maps: %s" % error, file=sys.stderr)
        return 1
    for problem in problems:
        print("left out: " + problem, file=sys.stderr)
    print("%d submaps in %s" % (len(merged), options.out))
    return 0
