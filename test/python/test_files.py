# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from voxnav import evaluation, files


def random_rotation(rng):
    q = rng.normal(size=4)
    return files.rotation_from_quaternion(q)


def test_quaternions_round_trip():
    rng = np.random.RandomState(1)
    for _ in range(200):
        R = random_rotation(rng)
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(files.rotation_from_quaternion(files.quaternion_from_rotation(R)), R, atol=1e-12)


def test_half_turns_round_trip():
    for axis in np.eye(3):
        R = 2 * np.outer(axis, axis) - np.eye(3)
        np.testing.assert_allclose(files.rotation_from_quaternion(files.quaternion_from_rotation(R)), R, atol=1e-12)


def test_tum_round_trip(tmp_path):
    rng = np.random.RandomState(2)
    poses = np.array([np.eye(4)] * 5)
    for T in poses:
        T[:3, :3] = random_rotation(rng)
        T[:3, 3] = rng.normal(size=3)
    path = str(tmp_path / "poses.txt")
    files.write_tum(path, np.arange(5.0), poses)
    stamps, read = files.read_tum(path)
    np.testing.assert_allclose(stamps, np.arange(5.0))
    np.testing.assert_allclose(read, poses, atol=1e-8)


@pytest.mark.parametrize("text, why", [
    ("1 2 3\n", "eight"), ("", "no poses"), ("0 0 0 0 0 0 0 0\n", "direction"), ("0 nan 0 0 0 0 0 1\n", "finite"),
    ("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "increase"),
])
def test_bad_tum_files_are_refused_with_the_reason(tmp_path, text, why):
    path = tmp_path / "bad.txt"
    path.write_text(text)
    with pytest.raises(ValueError, match=why):
        files.read_tum(str(path))


def test_ply_holds_what_was_written(tmp_path):
    path = str(tmp_path / "cloud.ply")
    points = np.arange(12, dtype=np.float32).reshape(4, 3)
    files.write_ply_points(path, points, np.full((4, 3), 7, np.uint8))
    with open(path, "rb") as source:
        header, body = source.read().split(b"end_header\n")
    assert b"element vertex 4" in header
    assert len(body) == 4 * (12 + 3)


def test_alignment_removes_a_rigid_motion():
    rng = np.random.RandomState(3)
    target = rng.normal(size=(50, 3)) * 10
    R, t = random_rotation(rng), rng.normal(size=3)
    stamps = np.arange(50.0)
    moved = (target - t) @ R
    assert evaluation.absolute_trajectory_error(stamps, moved, stamps, target) < 1e-9
    assert evaluation.absolute_trajectory_error(stamps, moved, stamps, target, align=False) > 1.0


def test_trajectories_that_do_not_overlap_are_refused():
    stamps = np.arange(5.0)
    with pytest.raises(evaluation.EvaluationError, match="0 of 5"):
        evaluation.absolute_trajectory_error(stamps + 100, np.zeros((5, 3)), stamps, np.zeros((5, 3)))
