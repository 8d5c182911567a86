# SPDX-License-Identifier: BSD-3-Clause
"""A* finds the published optimal costs of a benchmark of voxel maps.

Source: Brewer and Sturtevant, Benchmarks for Pathfinding in 3D Voxel Space, SoCS 2018.
"""

import os
import pathlib

import numpy as np
import pytest

import voxnav

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("VOXNAV_DATA", str(ROOT.parent / "shared" / "data"))) / "voxel_paths"


def load_map(path):
    """Returns a grid of 1 m voxels that are free unless the file lists them."""
    with open(str(path)) as lines:
        size = [int(n) for n in next(lines).split()[1:]]
        blocked = np.array([[int(n) for n in line.split()] for line in lines if line.strip()])
    states = np.ones(size, dtype=np.int8)
    states[tuple(blocked.T)] = 2
    return voxnav.StateGrid.from_array(states, (0.0, 0.0, 0.0), 1.0)


def load_queries(path):
    """Returns an array (n, 7) with start cell, goal cell and optimal cost."""
    with open(str(path)) as lines:
        rows = [line.split() for line in lines][2:]
    return np.array([[float(x) for x in row[:7]] for row in rows if len(row) >= 7])


@pytest.mark.skipif(not DATA.is_dir(), reason="needs the voxel_paths data (VOXNAV_DATA)")
def test_returns_the_published_optimal_cost_of_every_query():
    grid = load_map(DATA / "Simple.3dmap")
    queries = load_queries(DATA / "Simple.3dmap.3dscen")
    assert len(queries) == 10000
    planner = voxnav.AStarPlanner(
        voxnav.AStarConfig(safety_distance_m=0.0, timeout_s=60.0, max_expansions=5000000, unknown_policy="forbid")
    )
    wrong = []
    for query in queries:
        start, goal, optimal = query[0:3] + 0.5, query[3:6] + 0.5, query[6]
        result = planner.plan(grid, start, goal)
        length = np.linalg.norm(np.diff(result.path, axis=0), axis=1).sum()
        ends_there = len(result.path) > 0 and np.array_equal(result.path[-1], goal)
        if result.status != "complete" or not ends_there or abs(result.cost_m - optimal) > 2e-7 * optimal + 1e-7 or (
            abs(length - result.cost_m) > 1e-9 * optimal
        ):
            wrong.append((tuple(query), result.status, result.cost_m))
    assert wrong == []
