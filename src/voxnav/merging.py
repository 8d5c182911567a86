# SPDX-License-Identifier: BSD-3-Clause
"""``scripts/merge_maps``: two saved maps become one; where they overlap, the later flight says what is there now."""

import argparse
import sys

import numpy as np

import voxnav

# Submaps of one flight keep their places to each other as well as odometry does.
_CHAIN_INFORMATION = np.diag([1e2, 1e2, 2.5e3, 2.5e3])


def pose_from(x_y_z_yaw):
    """(4,) metres and radians -> (4, 4)."""
    x, y, z, yaw = x_y_z_yaw
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T[:3, 3] = x, y, z
    return T


def _closest(a, b):
    """Ids of the submaps of two flights ({id: T_W_S}) that lie nearest to each other."""
    ids = [(i, j) for i in a for j in b]
    return min(ids, key=lambda pair: np.linalg.norm(a[pair[0]][:3, 3] - b[pair[1]][:3, 3]))


def align(collection, first_ids, guess_sigma_m=2.0, guess_sigma_rad=0.1):
    """Registers the submaps of a merged collection to each other and moves them there.

    first_ids: of the first flight; its oldest submap stays. Returns the optimiser's report.
    """
    poses = collection.poses()
    flights = [{i: T for i, T in poses.items() if (i in first_ids) == is_first} for is_first in (True, False)]
    graph = voxnav.SubmapGraph()
    for i, T in poses.items():
        graph.add_submap(i, T, collection.submap(i))
    for flight in flights:
        ids = list(flight)
        for a, b in zip(ids, ids[1:]):
            graph.add_relative_pose(a, b, np.linalg.inv(flight[a]) @ flight[b], _CHAIN_INFORMATION)
    a, b = _closest(*flights)
    guess = np.diag([guess_sigma_m, guess_sigma_m, guess_sigma_m, guess_sigma_rad])
    graph.add_relative_pose(a, b, np.linalg.inv(poses[a]) @ poses[b], np.linalg.inv(guess @ guess), "loop")
    report = graph.optimize(full=True)
    collection.set_poses(graph.poses())
    return report


def merge(first, second, T_W_other, is_aligned=False):
    """Loads both maps (folders), adds the second as the newer one. Returns (SubmapCollection, what was left out)."""
    merged, problems = voxnav.SubmapCollection.load(first, recover=True)
    other, more = voxnav.SubmapCollection.load(second, recover=True)
    first_ids = set(merged.poses())
    merged.merge(other, T_W_other)
    if is_aligned and first_ids and len(merged) > len(first_ids):
        align(merged, first_ids)
    return merged, problems + more


def main(argv=None):
    parser = argparse.ArgumentParser(prog="merge_maps", description=__doc__)
    parser.add_argument("first", help="folder of a saved map")
    parser.add_argument("second", help="folder of the map of a later flight")
    parser.add_argument("out", help="folder for the map of both")
    parser.add_argument("--pose", nargs=4, type=float, default=[0.0, 0.0, 0.0, 0.0], metavar=("X", "Y", "Z", "YAW"),
                        help="of the second map's frame in the first's, metres and radians (default: the same frame)")
    parser.add_argument("--align", action="store_true", help="register the submaps of both flights to each other")
    options = parser.parse_args(argv)
    try:
        merged, problems = merge(options.first, options.second, pose_from(options.pose), options.align)
        merged.save(options.out)
    except (OSError, RuntimeError, ValueError) as error:
        print("merge_maps: %s" % error, file=sys.stderr)
        return 1
    for problem in problems:
        print("left out: " + problem, file=sys.stderr)
    print("%d submaps in %s" % (len(merged), options.out))
    return 0
