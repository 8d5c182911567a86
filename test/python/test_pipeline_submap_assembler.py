# SPDX-License-Identifier: BSD-3-Clause
"""SubmapAssembler, through Python, makes finished submaps of handovers and of clouds."""
import numpy as np
import pytest

import voxnav


def pose(x):
    T_O_B = np.eye(4)
    T_O_B[:3, 3] = (x, 0.2, 1.0)
    return T_O_B


def handovers(max_early_blocks=1024):
    """Returns the handovers of a sensor that flies 100 m along a wall, most of which leaves its window of 40 m."""
    m = voxnav.LocalMap(voxnav.LocalMapConfig(window_size_m=(40, 40, 20)))
    config = voxnav.SubmapSchedulerConfig(period_s=100.0, max_distance_m=1000.0, max_early_blocks=max_early_blocks)
    scheduler = voxnav.SubmapScheduler(config)
    wall = np.array([[0.1 * i, 5, 0.1 * j] for i in range(-20, 20) for j in range(-5, 5)], np.float32)
    out = []
    for i in range(101):
        m.insert(wall, pose(1.0 * i))
        out += scheduler.add_scan(m, 100.0 + 0.1 * i, pose(1.0 * i))
    return out + scheduler.finish(m)


def assembled(parts):
    assembler = voxnav.SubmapAssembler(voxnav.SubmapConfig())
    results = [assembler.add(part) for part in parts]
    assert all(result.submap is None for result in results[:-1])
    assert all(result.dropped is None for result in results)
    assert assembler.num_open == 0
    return results[-1].submap


def test_a_submap_handed_over_in_parts_is_the_same_as_in_one():
    parts, whole = handovers(max_early_blocks=4), handovers()
    assert len(parts) > 2 and len(whole) == 1
    assert [part.is_final for part in parts] == [False] * (len(parts) - 1) + [True]
    in_parts, at_once = assembled(parts), assembled(whole)
    assert len(at_once.submap.occupied_points()) > 100
    assert in_parts.submap.to_bytes() == at_once.submap.to_bytes()


def test_a_finished_submap_holds_the_poses_of_which_it_was_made():
    handover = handovers()[-1]
    finished = assembled([handover])
    assert finished.submap_id == handover.submap_id
    assert finished.start == pytest.approx(100.0) and finished.stamp == pytest.approx(110.0)
    assert np.array_equal(finished.T_O_S, handover.T_O_S)
    assert np.array_equal(finished.pose_stamps, handover.pose_stamps)
    assert np.array_equal(finished.T_S_B, handover.T_S_B)


def test_submaps_of_clouds_close_by_age():
    assembler = voxnav.SubmapAssembler(projective=voxnav.ProjectiveConfig(), projective_period_s=1.0)
    ground = np.array([[0.2 * x, 0.2 * y, -1.2] for x in range(-20, 20) for y in range(-20, 20)], np.float32)
    stamps = [5.0, 5.5, 6.0]
    for stamp in stamps:
        assert not assembler.is_due
        assembler.integrate(ground, pose(0.0), stamp)
    assert assembler.is_due
    finished = assembler.close()
    assert list(finished.pose_stamps) == stamps
    assert len(finished.submap.occupied_points()) > 50
    with pytest.raises(ValueError):
        assembler.integrate(ground.astype(np.float64), pose(0.0), 7.0)


def test_bad_arguments_have_reasons():
    with pytest.raises(ValueError, match="max_open_submaps"):
        voxnav.SubmapAssembler(max_open_submaps=0)
    with pytest.raises(RuntimeError, match="handovers"):
        voxnav.SubmapAssembler().close()
