# SPDX-License-Identifier: BSD-3-Clause
"""SubmapScheduler and deskewing work through Python as they do in the nodes."""
import numpy as np
import pytest

import voxnav


def pose(x):
    T_O_B = np.eye(4)
    T_O_B[:3, 3] = (x, 0.2, 1.0)
    return T_O_B


def test_a_submap_closes_after_its_period_with_the_content_of_the_map():
    m = voxnav.LocalMap(voxnav.LocalMapConfig(window_size_m=(40, 40, 20)))
    scheduler = voxnav.SubmapScheduler(voxnav.SubmapSchedulerConfig(period_s=1.0))
    wall = np.array([[5, 0.01 * i, 0.0] for i in range(100)], np.float32)
    closed = []
    for i in range(25):
        m.insert(wall, pose(0.0))
        closed += scheduler.add_scan(m, 100.0 + 0.1 * i, pose(0.01 * i))
    closed += scheduler.finish(m)
    assert [h.reason for h in closed] == ["time", "time", "shutdown"]
    assert [h.submap_id for h in closed] == [0, 1, 2]
    first = closed[0]
    assert first.is_final and first.start == pytest.approx(100.0) and first.stamp == pytest.approx(101.0)
    assert first.T_S_B.shape == (11, 4, 4) and first.pose_stamps.shape == (11,)
    assert closed[-1].content.num_occupied == len(m.occupied_centers())
    assert scheduler.finish(m) == []


def test_deskew_moves_points_by_the_motion_since_they_were_seen():
    points = np.array([[10, 0, 0], [10, 0, 0]], np.float32)
    end = np.eye(4)
    end[0, 3] = 1.0
    moved = voxnav.deskew(points, np.array([0, 100000000], np.uint32), np.eye(4), end, 0.1)
    assert moved[:, 0] == pytest.approx([9.5, 10.5], abs=1e-5)
    with pytest.raises(ValueError):
        voxnav.deskew(points, np.zeros(3, np.uint32), np.eye(4), end, 0.1)
