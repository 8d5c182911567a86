# SPDX-License-Identifier: BSD-3-Clause
"""SubmapGraph, through Python, reaches the cost that SciPy's least_squares finds for the same residuals."""

import numpy as np
import pytest
from scipy.optimize import least_squares

import voxnav


def wrap(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def matrix(pose):
    c, s = np.cos(pose[3]), np.sin(pose[3])
    out = np.eye(4)
    out[:2, :2] = [[c, -s], [s, c]]
    out[:3, 3] = pose[:3]
    return out


def compose(a, b):
    return np.append((matrix(a) @ np.append(b[:3], 1.0))[:3], wrap(a[3] + b[3]))


def relative(a, b):
    return np.append(matrix(a)[:3, :3].T @ (b[:3] - a[:3]), wrap(b[3] - a[3]))


def manhattan_world(size, seed, correlated=True):
    """Returns a random walk on a grid, with edges between successive poses and between visits to the same place."""
    rng = np.random.default_rng(seed)
    truth = [np.zeros(4)]
    for _ in range(size - 1):
        turn = rng.choice([0.0, 0.0, np.pi / 2, -np.pi / 2])
        truth.append(compose(truth[-1], np.array([2.0, 0.0, 0.0, turn])))
    places = np.array(truth)[:, :3]
    pairs = [(i, i + 1) for i in range(size - 1)]
    for a in range(size):
        near = a + 5 + np.flatnonzero(np.linalg.norm(places[a + 5:] - places[a], axis=1) < 0.5)
        pairs += [(a, int(b)) for b in near[:2]]
    sigma = np.array([0.05, 0.05, 0.03, 0.01])
    edges = []
    for a, b in pairs:
        mix = np.eye(4) + (0.3 * rng.normal(size=(4, 4)) if correlated else 0.0)
        root = np.diag(sigma) @ mix
        covariance = root @ root.T
        edges.append((a, b, relative(truth[a], truth[b]) + root @ rng.normal(size=4), np.linalg.inv(covariance)))
    start = [truth[0]]
    for a, b, measured, _ in edges[:size - 1]:
        start.append(compose(start[-1], measured))
    return np.array(truth), np.array(start), edges


def scipy_cost(start, edges):
    """Returns the cost that SciPy reaches with residuals whitened by the Cholesky factor of the information."""
    roots = np.array([np.linalg.cholesky((m + m.T) / 2).T for _, _, _, m in edges])
    a = np.array([edge[0] for edge in edges])
    b = np.array([edge[1] for edge in edges])
    measured = np.array([edge[2] for edge in edges])

    def residuals(x):
        poses = np.vstack([start[0], x.reshape(-1, 4)])
        c, s = np.cos(poses[a, 3]), np.sin(poses[a, 3])
        d = poses[b] - poses[a]
        error = np.stack([c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1], d[:, 2], d[:, 3]], axis=1) - measured
        error[:, 3] = wrap(error[:, 3])
        return np.einsum("kij,kj->ki", roots, error).ravel()

    # Dense Levenberg-Marquardt with numeric derivatives is slow, but has nothing in common with the code under test.
    result = least_squares(residuals, start[1:].ravel(), method="lm", ftol=1e-12, xtol=1e-12, gtol=1e-12)
    return 2.0 * result.cost


def graph_of(start, edges, kind="odometry"):
    graph = voxnav.SubmapGraph(voxnav.SubmapGraphConfig())
    for i, pose in enumerate(start):
        graph.add_submap(i, matrix(pose))
    for a, b, measured, information in edges:
        graph.add_relative_pose(a, b, matrix(measured), information, kind="odometry" if b == a + 1 else kind)
    return graph


def mean_error(graph, truth):
    return np.mean([np.linalg.norm(pose[:3, 3] - truth[i][:3]) for i, pose in graph.poses().items()])


@pytest.mark.parametrize("size, seed", [(60, 1), (60, 2), (100, 3)])
def test_optimize_reaches_the_cost_of_an_independent_solver(size, seed):
    _, start, edges = manhattan_world(size, seed)
    assert len(edges) > size
    expected = scipy_cost(start, edges)
    report = graph_of(start, edges).optimize()
    assert report.is_converged
    assert report.cost_after == pytest.approx(expected, rel=1e-3)


def test_true_loops_all_pass_the_gate():
    truth, start, edges = manhattan_world(300, 4)
    graph = graph_of(start, edges, kind="loop")
    report = graph.optimize()
    assert report.rejected_loops == []
    assert report.num_constraints["loop"] == len(edges) - len(start) + 1
    assert mean_error(graph, truth) < 0.8 * np.linalg.norm(start[:, :3] - truth[:, :3], axis=1).mean()


def test_large_manhattan_world_lowers_cost_and_converges():
    truth, start, edges = manhattan_world(1500, 5)
    graph = graph_of(start, edges)
    report = graph.optimize()
    # The chi-square of a good fit is near its degrees of freedom.
    freedom = 4 * (len(edges) - len(start) + 1)
    assert report.is_converged
    assert 0.8 * freedom < report.cost_after < 1.2 * freedom
    assert mean_error(graph, truth) < 0.8 * np.linalg.norm(start[:, :3] - truth[:, :3], axis=1).mean()


def test_g2o_round_trip_keeps_the_solution():
    _, start, edges = manhattan_world(60, 6)
    graph = graph_of(start, edges, kind="loop")
    copy = voxnav.SubmapGraph.from_g2o(graph.to_g2o())
    cost = graph.optimize().cost_after
    assert copy.optimize().cost_after == pytest.approx(cost, rel=1e-9)
    assert graph.poses().keys() == copy.poses().keys()
    with pytest.raises(ValueError, match="line 1"):
        voxnav.SubmapGraph.from_g2o("VERTEX_SE2 0 0 0\n")


def test_first_submap_stays_and_report_names_every_kind():
    _, start, edges = manhattan_world(30, 7)
    graph = graph_of(start, edges)
    report = graph.optimize()
    np.testing.assert_array_equal(graph.poses()[0], matrix(start[0]))
    assert set(report.costs) == {"odometry", "registration", "loop", "gnss", "height"}
    assert report.num_constraints["odometry"] == len(edges)
    assert report.iterations >= 1 and report.seconds >= 0.0 and report.pairs == 0


def test_position_pulls_a_submap():
    graph = voxnav.SubmapGraph()
    graph.add_submap(0, np.eye(4))
    graph.add_submap(1, matrix([10.0, 0, 0, 0]))
    graph.add_relative_pose(0, 1, matrix([10.0, 0, 0, 0]), np.eye(4), kind="odometry")
    graph.add_position(1, [0.0, 0.0, 0.0], [10.0, 2.0, 0.0], np.eye(3) * 1e-6)
    graph.optimize()
    assert graph.poses()[1][1, 3] == pytest.approx(2.0, abs=0.01)


def test_wrong_arguments_raise_value_errors():
    graph = voxnav.SubmapGraph()
    graph.add_submap(0, np.eye(4))
    graph.add_submap(1, np.eye(4))
    with pytest.raises(ValueError):
        graph.add_submap(0, np.eye(4))
    with pytest.raises(ValueError):
        graph.add_submap(2, np.eye(3))
    with pytest.raises(ValueError):
        graph.add_submap(2, np.eye(4, dtype=np.float32))
    with pytest.raises(ValueError, match="kind"):
        graph.add_relative_pose(0, 1, np.eye(4), np.eye(4), kind="magic")
    with pytest.raises(ValueError, match="unknown submap 9"):
        graph.add_relative_pose(0, 9, np.eye(4), np.eye(4))
    with pytest.raises(ValueError, match="information"):
        graph.add_relative_pose(0, 1, np.eye(4), -np.eye(4))
    with pytest.raises(voxnav.ConfigError, match="noise_flor"):
        voxnav.SubmapGraphConfig(noise_flor=0.1)


def test_correct_trajectory_blends_between_submaps():
    stamps = np.arange(0.0, 20.5, 0.5)
    odometry = np.array([matrix([t, 0, 0, 0]) for t in stamps])
    submaps = np.array([matrix([0.0, 0, 0, 0]), matrix([10.0, 0, 0, 0])])
    moved = np.array([matrix([0.0, 0, 0, 0]), matrix([10.0, 1.0, 0, 0])])
    out = voxnav.correct_trajectory(stamps, odometry, np.array([[0.0, 10.0], [10.0, 20.0]]), submaps, moved)
    assert out.shape == (41, 4, 4)
    np.testing.assert_allclose(out[stamps == 5.0][0], odometry[stamps == 5.0][0], atol=1e-9)
    assert out[stamps == 10.0][0][1, 3] == pytest.approx(0.5)
    assert np.abs(np.diff(out[:, 1, 3])).max() < 0.06
    with pytest.raises(ValueError):
        voxnav.correct_trajectory(stamps, odometry, np.array([[10.0, 20.0], [0.0, 10.0]]), submaps, moved)


def test_submap_bends_lead_half_of_the_way_to_the_neighbour():
    spans = np.array([[0.0, 10.0], [10.0, 20.0], [20.0, 24.0]])
    submaps = np.array([matrix([10.0 * k, 0, 0, 0]) for k in range(3)])
    moved = np.array([matrix([10.0 * k, 1.0 * k, 0, 0]) for k in range(3)])
    bends = voxnav.submap_bends(spans, submaps, moved, 2.0)
    np.testing.assert_allclose(bends[:, 0, 1, 3], [0.0, -0.5, -2.0 / 7.0], atol=1e-9)
    np.testing.assert_allclose(bends[:, 1, 1, 3], [0.5, 5.0 / 7.0, 0.0], atol=1e-9)
    np.testing.assert_array_equal(voxnav.submap_bends(spans, submaps, moved, 0.0), np.tile(np.eye(4), (3, 2, 1, 1)))
