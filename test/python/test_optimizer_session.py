# SPDX-License-Identifier: BSD-3-Clause
"""The session of the submap optimiser, without ROS, takes submaps, loops, GNSS and heights and corrects the poses."""

import os

import numpy as np
import pytest

import voxnav
from voxnav.optimizer_session import (Fix, Height, Loop, OptimizerSession, SubmapRecord, body_pose_at,
                                      loop_between_submaps)

PERIOD_S = 10.0


def body_at(t):
    """Returns the true pose on a circle with a radius of 30 m that takes 200 s."""
    angle = 2.0 * np.pi * t / 200.0
    return voxnav.pose_from_yaw([30.0 * np.sin(angle), 30.0 * (1.0 - np.cos(angle)), 5.0], angle)


def drifted(T, t):
    """Returns the pose that odometry reports, which drifts slowly in position and heading."""
    return voxnav.pose_from_yaw([0.01 * t, 0.004 * t, 0.0], 0.0004 * t) @ T


def record_of(k, count=11):
    stamps = PERIOD_S * k + np.linspace(0.0, PERIOD_S, count)
    T_O_B = np.array([drifted(body_at(t), t) for t in stamps])
    T_O_S = T_O_B[0]
    return SubmapRecord(k, stamps[0], stamps[-1], T_O_S, stamps, np.linalg.inv(T_O_S) @ T_O_B)


def flown(count, **config):
    session = OptimizerSession(config=voxnav.OptimizerConfig(**config))
    for k in range(count):
        assert session.add_submap(record_of(k))
    return session


def true_loop(t_a, t_b, sigma=0.05):
    return Loop(t_a, t_b, np.linalg.inv(body_at(t_a)) @ body_at(t_b), np.eye(6) * sigma ** 2)


def error_at(session, t):
    stamps, poses = session.trajectory()
    i = int(np.argmin(np.abs(stamps - t)))
    return np.linalg.norm(poses[i][:3, 3] - body_at(stamps[i])[:3, 3])


def test_body_pose_is_interpolated_and_never_extrapolated():
    record = record_of(2)
    expected = np.linalg.inv(record.T_O_S) @ drifted(body_at(23.5), 23.5)
    np.testing.assert_allclose(body_pose_at(record, 23.5), expected, atol=0.01)
    assert body_pose_at(record, 19.9) is None
    assert body_pose_at(record, 30.1) is None


def test_loop_between_submaps_matches_the_chain_of_poses():
    a, b = voxnav.pose_from_yaw([1.0, 2.0, 0.5], 0.4), voxnav.pose_from_yaw([-3.0, 1.0, 0.2], -2.0)
    T_A_B = voxnav.pose_from_yaw([5.0, -2.0, 1.0], 1.2)
    T, information = loop_between_submaps(a, b, T_A_B, np.eye(6) * 0.01)
    np.testing.assert_allclose(T, a @ T_A_B @ np.linalg.inv(b), atol=1e-12)
    # The information must be the inverse of the covariance of the submap's pose, which is sampled here.
    rng = np.random.default_rng(1)
    errors = []
    for noise in rng.normal(scale=0.1, size=(20000, 4)) * [1, 1, 1, 0.1]:
        noisy = voxnav.pose_from_yaw(T_A_B[:3, 3] + noise[:3], 1.2 + noise[3])
        delta = a @ noisy @ np.linalg.inv(b)
        errors.append(np.append(delta[:3, 3] - T[:3, 3], noise[3]))
    covariance = np.diag([0.01, 0.01, 0.01, 1.0, 1.0, 0.0001])
    _, information = loop_between_submaps(a, b, T_A_B, covariance)
    np.testing.assert_allclose(np.cov(np.array(errors).T), np.linalg.inv(information), atol=8e-4)


def test_newest_submap_does_not_jump():
    session = flown(20)
    session.add_loop(true_loop(2.0, 198.0))
    session.optimize()
    newest = session.records[19]
    np.testing.assert_allclose(session.T_W_O @ newest.T_O_S, session.graph.poses()[19], atol=1e-9)
    assert np.linalg.norm(session.T_W_O[:3, 3]) > 0.1


def test_loop_corrects_the_end_of_the_trajectory():
    session = flown(20)
    before = error_at(session, 199.0)
    session.add_loop(true_loop(2.0, 198.0))
    report = session.optimize()
    assert report.rejected_loops == []
    assert before > 1.0
    assert error_at(session, 199.0) < 0.3


def test_bends_lead_from_submap_to_submap():
    session = flown(20)
    assert all(np.allclose(bend, np.eye(4)) for bend in session.bends().values())
    session.add_loop(true_loop(2.0, 198.0))
    session.optimize()
    poses, bends, records = session.graph.poses(), session.bends(), session.records
    for k in range(1, 20):
        T_a_b = np.linalg.inv(records[k - 1].T_O_S) @ records[k].T_O_S
        np.testing.assert_allclose(poses[k - 1] @ bends[k - 1][1] @ T_a_b, poses[k] @ bends[k][0], atol=1e-3)
    assert max(np.linalg.norm(bend[0, :3, 3]) for bend in bends.values()) > 0.005


def test_loop_waits_for_its_submaps():
    session = flown(10)
    session.add_loop(true_loop(2.0, 198.0))
    assert session.optimize().num_constraints["loop"] == 0
    for k in range(10, 20):
        session.add_submap(record_of(k))
    assert session.optimize().num_constraints["loop"] == 1


def test_loop_that_can_never_be_used_is_counted():
    session = flown(3)
    session.add_loop(true_loop(-50.0, 5.0))
    session.add_loop(true_loop(3.0, 5.0))
    assert session.dropped["loop"] == 2
    with pytest.raises(ValueError):
        session.add_loop(Loop(1.0, 25.0, np.eye(4), np.zeros((6, 6))))
    with pytest.raises(ValueError):
        session.add_loop(Loop(1.0, 25.0, np.full((4, 4), np.nan), np.eye(6)))


def test_pending_loops_are_bounded():
    session = flown(1, max_pending=5)
    for _ in range(8):
        session.add_loop(true_loop(2.0, 500.0))
    assert session.dropped["loop"] == 3


def test_submaps_are_taken_once_and_reused_ids_refused():
    session = flown(3)
    assert not session.add_submap(record_of(2))
    with pytest.raises(ValueError, match="another time"):
        session.add_submap(record_of(7)._replace(id=2))


def test_gnss_in_its_own_frame_removes_drift():
    T_G_W = voxnav.pose_from_yaw([1000.0, -200.0, 300.0], 1.0)
    session = OptimizerSession(config=voxnav.OptimizerConfig(gnss_lever_arm_m=[0.1, 0.0, 0.2]))
    for k in range(20):
        for t in PERIOD_S * k + np.array([1.0, 4.0, 8.0]):
            antenna = body_at(t) @ np.array([0.1, 0.0, 0.2, 1.0])
            session.add_fix(Fix(t, (T_G_W @ antenna)[:3], np.eye(3) * 1e-4))
        session.add_submap(record_of(k))
        report = session.optimize()
    assert report.num_constraints["gnss"] == 40
    # GNSS in a frame of its own leaves the rotation about the start free, so only the distance from the start counts.
    stamps, poses = session.trajectory()
    i = int(np.argmin(np.abs(stamps - 195.0)))
    flown_m = np.linalg.norm(poses[i][:3, 3] - poses[0][:3, 3])
    true_m = np.linalg.norm(body_at(stamps[i])[:3, 3] - body_at(0.0)[:3, 3])
    assert abs(flown_m - true_m) < 0.3


def test_bad_fixes_and_heights_are_counted():
    session = flown(1)
    assert not session.add_fix(Fix(1.0, np.array([np.nan, 0, 0]), np.eye(3)))
    assert not session.add_fix(Fix(1.0, np.zeros(3), np.eye(3) * 1e6))
    assert not session.add_height(Height(1.0, float("nan")))
    assert session.dropped["gnss"] == 2 and session.dropped["height"] == 1


def test_heights_correct_z_drift():
    session = OptimizerSession(config=voxnav.OptimizerConfig(height_sigma_m=0.05))
    for k in range(10):
        record = record_of(k)
        sunk = record.T_O_S.copy()
        sunk[2, 3] -= 0.1 * k
        for t in record.stamps_s[1::4]:
            session.add_height(Height(t, 105.0))
        session.add_submap(record._replace(T_O_S=sunk))
        session.optimize()
    assert session.graph.poses()[9][2, 3] == pytest.approx(5.0, abs=0.15)


def test_trajectory_is_thinned_to_its_limit_and_has_no_steps():
    session = flown(20, max_trajectory_poses=100)
    session.add_loop(true_loop(2.0, 198.0))
    session.optimize()
    stamps, poses = session.trajectory()
    assert len(stamps) <= 100 and len(stamps) == len(poses)
    steps = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    assert steps.max() < 1.5 * np.median(steps[steps > 0.01])


def test_an_empty_session_can_be_queried():
    session = OptimizerSession()
    assert session.optimize().is_converged
    stamps, poses = session.trajectory()
    assert len(stamps) == 0 and poses.shape == (0, 4, 4)
    np.testing.assert_array_equal(session.T_W_O, np.eye(4))


def test_shipped_parameters_are_the_defaults():
    yaml = pytest.importorskip("yaml")
    path = os.path.join(os.path.dirname(__file__), "..", "..", "config", "submap_optimizer.yaml")
    with open(path) as source:
        sections = yaml.safe_load(source)
    assert sections == {"node": voxnav.OptimizerConfig().to_dict(), "graph": voxnav.SubmapGraphConfig().to_dict(),
                        "time": voxnav.TimeConfig().to_dict()}
