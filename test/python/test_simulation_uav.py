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


def faults(**sections):
    out = simulation.UavFaults()
    for name, section in sections.items():
        setattr(out, name, section)
    return out


def largest_error(uav, duration_s):
    """Returns the largest distance between the tracker and the true place over a time, for a vehicle without drift."""
    worst = 0.0
    for _ in range(int(duration_s / 0.05)):
        uav.step(0.05)
        worst = max(worst, np.linalg.norm(uav.prediction()[0, 1:4] - uav.truth[:3, 3] - uav.drift))
    return worst


def test_a_vehicle_lags_behind_its_tracker_and_is_pushed_by_wind():
    errors = []
    for lags, gust_mps in ((False, None), (True, None), (True, 4.0)):
        wind = simulation.WindConfig(is_enabled=gust_mps is not None, gust_mps=gust_mps or 0.0)
        uav = flying(seed=3, faults=faults(tracking=simulation.TrackingConfig(is_enabled=lags), wind=wind))
        uav.go_to([40.0, 0.0, 2.0], 0.0)
        errors.append(largest_error(uav, 14.0))
    assert errors[0] < 0.05, "the prediction begins 0.01 s ahead"
    assert 0.1 < errors[1] < errors[2] < 1.0


def test_faults_are_values_of_their_own():
    off = simulation.UavFaults()
    assert not any(getattr(off, name).is_enabled for name in (
        "tracking", "wind", "state_noise", "refusals", "avoidance", "bumper", "resets"))
    with pytest.raises(ConfigError, match="unstable"):
        simulation.Uav(faults=faults(tracking=simulation.TrackingConfig(delay_s=0.5, is_enabled=True)))


def test_the_bumper_keeps_away_from_the_trees_of_a_scene():
    world = simulation.World({"trees_per_ha": 300.0, "num_walls": 0, "num_houses": 0, "terrain_amplitude_m": 0.0,
                              "bushes_per_ha": 0.0, "rocks_per_ha": 0.0, "low_branch_ratio": 0.0}, seed=2)
    trunk = min(world.trunks().ground, key=lambda p: np.linalg.norm(p[:2]))
    repels = simulation.BumperConfig(is_enabled=True, is_derived_from_dynamics=False)
    clearances = []
    for sections in ({}, {"bumper": repels}):
        uav = flying(seed=1, constraints="slow", scene=world.scene, faults=faults(**sections),
                     drift=simulation.GnssDriftConfig(bound_m=0.0))
        uav.go_to([trunk[0], trunk[1], 2.0], 0.0)
        was_repelled, nearest_m = False, 100.0
        for _ in range(200):
            uav.step(0.1)
            was_repelled |= uav.is_repelled
            nearest_m = min(nearest_m, world.clearance(uav.truth[:3, 3])[0])
        clearances.append(nearest_m)
        assert was_repelled == bool(sections)
    assert clearances[0] < 0.4 < 0.5 < clearances[1]
