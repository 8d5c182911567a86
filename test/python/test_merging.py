# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

import voxnav
from voxnav.merging import main, pose_from

VOXEL = 0.4


def yard(first, last):
    """Returns the part of uneven ground, walls and posts that a flight from x = first to x = last (in voxels) sees."""
    states = np.ones((last - first, 60, 20), np.int8)
    for x in range(first, last):
        for y in range(60):
            states[x - first, y, :1 + (x * 7 + y * 3) % 23 // 11] = 2
        states[x - first, 58, :9] = 2
    for x, y in ((5, 9), (17, 33), (30, 14), (41, 44), (52, 20), (64, 37), (77, 8)):
        if first <= x < last:
            states[x - first, y:y + 2, :14] = 2
            states[x - first, 1:40, 15] = 2 if x % 2 else 1
    return voxnav.map_content_from_array(states, (first * VOXEL, -12.0, 0.0), VOXEL)


def save(directory, parts):
    c = voxnav.SubmapCollection()
    for i, (first, last) in enumerate(parts):
        c.add(i, voxnav.Submap.from_content(yard(first, last), np.eye(4)), np.eye(4), stamp=float(i))
    c.save(directory)


@pytest.fixture
def maps(tmp_path):
    save(str(tmp_path / "a"), [(0, 50), (15, 65)])
    save(str(tmp_path / "b"), [(30, 80)])
    return str(tmp_path / "a"), str(tmp_path / "b"), str(tmp_path / "both")


def test_flights_in_one_frame_are_joined(maps):
    assert main(list(maps)) == 0
    both = voxnav.SubmapCollection.load(maps[2])
    assert sorted(both.poses()) == [0, 1, 2]
    x = both.occupied_points()[:, 0]
    assert x.min() < 1.0 and x.max() > 31.0


def test_the_second_map_is_moved(maps):
    assert main(list(maps) + ["--pose", "100", "0", "0", "0.5"]) == 0
    poses = voxnav.SubmapCollection.load(maps[2]).poses()
    np.testing.assert_allclose(poses[2], pose_from((100, 0, 0, 0.5)), atol=1e-12)


def test_maps_that_cannot_be_read_are_named(maps, capsys):
    assert main([maps[0], maps[1] + "_absent", maps[2]]) == 1
    assert "_absent/index.vxi" in capsys.readouterr().err
