# SPDX-License-Identifier: BSD-3-Clause
"""The simulated vehicle, through Python, flies within limits and as it predicts."""
import numpy as np
import pytest

simulation = pytest.importorskip("voxnav.simulation", reason="the simulator is not built (no Embree)")
from voxnav import ConfigError  # noqa: E402


def flying(**kwargs):
    uav = simulation.Uav(**kwargs)
    uav.take_off()
    uav.step(6.0)
    assert uav.phase == "flying"
    return uav


def test_flies_through_waypoints_and_stops():
    uav = flying(seed=3)
    waypoints = np.array([[10.0, 0, 3, 0], [15, 5, 3, 1], [15, 15, 4, 1.5]])
    samples = uav.fly_through(waypoints, max_deviation_m=0.3)
    imu = uav.step(0.2 * len(samples) + 2)
    assert imu.shape[1] == 7 and np.allclose(np.diff(imu[:, 0]), 0.005)
    assert np.linalg.norm(uav.estimate[:3, 3] - waypoints[-1, :3]) < 0.05
    assert not uav.has_goal
    assert np.allclose(uav.estimate[:3, 3] - uav.truth[:3, 3], uav.drift)


def test_prediction_is_flown():
    uav = flying()
    uav.go_to([20, 0, 3], 0.5)
    uav.step(1.0)
    prediction = uav.prediction()
    assert prediction.shape == (40, 8)
    uav.step(0.01 + 0.2 * 20)
    assert np.allclose(uav.estimate[:3, 3], prediction[20, 1:4], atol=1e-9)


def test_generate_trajectory_keeps_limits():
    waypoints = np.array([[0.0, 0, 2, 0], [20, 0, 2, 0], [20, 20, 2, 0]])
    out = simulation.generate_trajectory(waypoints, constraints="fast", max_deviation_m=0.3)
    velocity = np.diff(out["points"][:, :3], axis=0) / out["dt_s"]
    assert np.linalg.norm(velocity, axis=1).max() <= 8
    assert out["deviation_m"] <= 0.3
    assert np.allclose(out["points"][-1, :3], waypoints[-1, :3])


def test_refusals_name_the_reason():
    uav = simulation.Uav()
    with pytest.raises(ValueError, match="not flying"):
        uav.hover()
    uav = flying()
    with pytest.raises(ValueError, match="not finite"):
        uav.set_trajectory(np.full((3, 4), np.nan))
    with pytest.raises(ValueError, match="empty"):
        uav.set_trajectory(np.empty((0, 4)))
    with pytest.raises(ValueError, match="points must be"):
        uav.set_trajectory(np.zeros((3, 3)))
    with pytest.raises(ValueError, match="constraints must be"):
        simulation.Uav(constraints="ludicrous")
    with pytest.raises(ConfigError, match="take_off_height_m"):
        simulation.UavConfig(take_off_height_m=-1.0)


def test_same_seed_same_flight():
    a, b = (flying(seed=5) for _ in range(2))
    assert np.array_equal(a.truth, b.truth)
    assert not np.array_equal(a.truth, flying(seed=6).truth)
