# SPDX-License-Identifier: BSD-3-Clause
"""The evaluation of alignment measures known errors, and the graph does not make a short flight worse."""
import numpy as np
import pytest

from voxnav import pose_from_yaw
from voxnav.alignment.flight import drift_of, fly, kept_flight
from voxnav.alignment.measure import errors_of, solve
from voxnav.alignment.scenarios import SCENARIOS, path_of

SHORT = SCENARIOS["corridor"]._replace(corners=np.array([(0.0, 0.0), (20.0, 0.0), (0.0, 0.0)]), scan_hz=2.0)


def poses(xyz):
    return np.array([pose_from_yaw(p, 0.0) for p in xyz])


def test_errors_are_those_of_an_aligned_trajectory():
    true = poses(np.random.RandomState(3).uniform(-20, 20, (50, 3)))
    moved = pose_from_yaw((5.0, -3.0, 1.0), 0.7) @ true
    assert errors_of(moved, true).rmse_m < 1e-9 and errors_of(moved, true).closure_m < 1e-9
    bent = true.copy()
    bent[::2, 2, 3] += 0.4  # half of the poses are 0.4 m too high, so that aligned ones are off by 0.2 m either way
    errors = errors_of(bent, true)
    assert errors.axis_m[2] == pytest.approx(0.2, abs=0.02) and errors.axis_m[:2].max() < 0.05


def test_drift_begins_at_zero_peaks_at_its_configured_size_and_depends_on_the_seed():
    drift = drift_of(SCENARIOS["loop"], 1500, 7)
    assert np.linalg.norm(drift[0]) < 1e-3
    assert np.linalg.norm(drift, axis=1).max() == pytest.approx(1.8)
    assert np.linalg.norm(np.diff(drift, axis=0), axis=1).max() < 0.1
    np.testing.assert_array_equal(drift, drift_of(SCENARIOS["loop"], 1500, 7))
    assert not np.array_equal(drift, drift_of(SCENARIOS["loop"], 1500, 8))


def test_corridor_flight_is_not_bent_and_repeats(tmp_path):
    flight = kept_flight(SHORT, 1, str(tmp_path))
    solved = solve(flight)
    assert len(flight.submaps) >= 4
    assert solved.worst_excess_m < 0.005
    again = solve(kept_flight(SHORT, 1, str(tmp_path)))
    np.testing.assert_array_equal(solved.T_W_B, again.T_W_B)
    np.testing.assert_array_equal(fly(SHORT, 1).T_O_B, flight.T_O_B)


def test_paths_keep_clear_of_trees():
    simulation = pytest.importorskip("voxnav.simulation")
    scenario = SCENARIOS["loop"]
    world = simulation.World(scenario.world, 2)
    path = path_of(scenario, world)
    assert np.linalg.norm(path[0, :2] - path[-1, :2]) < 0.5
    assert np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).sum() == pytest.approx(300.0, rel=0.1)
    assert np.quantile(world.clearance(path[:, :3]), 0.01) > 0.3
