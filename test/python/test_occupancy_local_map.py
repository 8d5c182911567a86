# SPDX-License-Identifier: BSD-3-Clause
"""LocalMap, through Python, answers queries, refuses wrong arrays, and can be saved, loaded and exported."""
import re

import numpy as np
import pytest

import voxnav


def pose(x=0.2, y=0.2, z=0.2):
    T_W_L = np.eye(4)
    T_W_L[:3, 3] = (x, y, z)
    return T_W_L


def wall_map(scans=4):
    m = voxnav.LocalMap(voxnav.LocalMapConfig(window_size_m=(40, 40, 20)))
    y, z = np.meshgrid(np.arange(-3, 3, 0.05), np.arange(-1, 1, 0.05))
    points = np.stack([np.full(y.size, 6.0), y.ravel(), z.ravel()], axis=1).astype(np.float32)
    for _ in range(scans):
        statistics = m.insert(points, pose())
    return m, statistics


def test_states_and_centers_agree():
    m, statistics = wall_map()
    assert statistics.points == 120 * 40 and statistics.cells_hit > 0 and statistics.seconds > 0
    occupied = m.occupied_centers()
    free = m.free_centers()
    assert len(occupied) > 50 and len(free) > 200
    assert occupied.dtype == np.float32 and occupied.shape[1] == 3
    assert (m.states(occupied) == 2).all() and (m.states(free) == 1).all()
    assert m.states(np.array([[9, 0, 0], [np.nan, 0, 0]], np.float32)).tolist() == [0, 0]
    assert np.abs(m.occupied_points()[:, 0] - 6.2).max() < 1e-3


def test_corridor_reports_where_it_ends():
    m, _ = wall_map()
    assert m.corridor_state((0.2, 0.2, 0.2), (4, 0.2, 0.2), 0.1) == (1, None)
    worst, first_bad_m = m.corridor_state((0.2, 0.2, 0.2), (8, 0.2, 0.2), 0.1)
    assert worst == 2 and first_bad_m == pytest.approx(6.0 - 0.2 - 0.1, abs=0.01)
    assert m.corridor_state((0.2, 0.2, 0.2), (-4, 0.2, 0.2), 0.1)[0] == 0
    with pytest.raises(ValueError):
        m.corridor_state((np.nan, 0, 0), (1, 0, 0), 0.1)


def test_wrong_arrays_are_refused():
    m = voxnav.LocalMap()
    for bad in (np.zeros((5, 2), np.float32), np.zeros((5, 3)), np.zeros(3, np.float32)):
        with pytest.raises(ValueError):
            m.insert(bad, pose())
    with pytest.raises(ValueError):
        m.insert(np.zeros((5, 3), np.float32), np.zeros((4, 4)))
    with pytest.raises(voxnav.ConfigError, match="MB"):
        voxnav.LocalMap(voxnav.LocalMapConfig(resolution_m=0.02))
    with pytest.raises(voxnav.ConfigError):
        voxnav.LocalMapConfig(resolution=0.4)


def test_save_load_and_octomap(tmp_path):
    m, _ = wall_map()
    m.save(str(tmp_path / "map.vxlm"))
    read = voxnav.LocalMap.load(str(tmp_path / "map.vxlm"))
    assert read.to_bytes() == m.to_bytes()
    m.save_octomap(str(tmp_path / "map.ot"))
    m.save_octomap(str(tmp_path / "map.bt"))
    assert (tmp_path / "map.ot").stat().st_size > (tmp_path / "map.bt").stat().st_size > 100
    (tmp_path / "short").write_bytes(m.to_bytes()[:-7])
    with pytest.raises(ValueError):
        voxnav.LocalMap.load(str(tmp_path / "short"))


def test_content_survives_its_byte_form():
    m, _ = wall_map()
    content = m.content()
    assert content.num_occupied == len(m.occupied_centers())
    again = voxnav.MapContent.from_bytes(content.to_bytes())
    assert np.abs(np.sort(again.occupied_points(), axis=0) - np.sort(m.occupied_points(), axis=0)).max() < 2e-3
    m.clear()
    assert m.content().num_blocks == 0 and len(m.occupied_points()) == 0


def test_memory_stays_below_the_bound():
    m, _ = wall_map()
    assert 0 < m.memory_bytes < 10e6


def test_changes_and_octomap_import(tmp_path):
    m, _ = wall_map()
    is_snapshot, blocks, states, removed = m.changes_since(0)
    assert is_snapshot and blocks.shape == (len(states), 3) and states.shape[1] == 1024 and len(removed) == 0
    before = m.sequence
    m.insert(np.zeros((0, 3), np.float32), pose())
    is_snapshot, blocks, _, _ = m.changes_since(before)
    assert not is_snapshot and len(blocks) == 0 and m.sequence > before
    m.save_octomap(str(tmp_path / "map.ot"))
    read = voxnav.LocalMap.load_octomap(str(tmp_path / "map.ot"), m.config, (0.2, 0.2, 0.2))
    assert (read.states(m.occupied_centers()) == 2).all() and (read.states(m.free_centers()) == 1).all()
    with pytest.raises(RuntimeError):
        voxnav.LocalMap.load_octomap(str(tmp_path / "none.bt"))


def test_octomap_import_counts_what_lies_outside_the_window(tmp_path):
    m, _ = wall_map()
    path = str(tmp_path / "map.ot")
    assert m.save_octomap(path) is None
    known = len(m.occupied_centers()) + len(m.free_centers())
    small = voxnav.LocalMapConfig(window_size_m=(4, 4, 4))
    with pytest.warns(UserWarning, match=r"outside the window") as said:
        read = voxnav.LocalMap.load_octomap(path, small, (0.2, 10.0, 0.2))
    lost = known - len(read.occupied_centers()) - len(read.free_centers())
    assert 0 < lost < known
    assert re.match(r"\d+ of \d+ voxels of ", str(said[0].message))
    assert int(str(said[0].message).split()[0]) >= lost
    with pytest.warns(UserWarning, match=r"outside the window"):
        read = voxnav.LocalMap.load_octomap(path, small, (1e6, 0, 0))
    assert len(read.occupied_centers()) == 0 and len(read.free_centers()) == 0


@pytest.mark.parametrize("ending", [".ot", ".bt"])
def test_octomap_of_a_map_far_from_the_origin_states_its_shift(tmp_path, ending):
    m = voxnav.LocalMap(voxnav.LocalMapConfig(window_size_m=(40, 40, 20)))
    center = (5.0e5, 5.5e6, 300.0)
    for _ in range(4):
        m.insert(np.array([[5, y, 0.1] for y in np.arange(-2, 2, 0.1)], np.float32), pose(*center))
    path = str(tmp_path / "map") + ending
    with pytest.warns(UserWarning, match="was shifted; add"):
        shift = m.save_octomap(path)
    assert np.abs(np.array(center) - shift).max() < 0.4 * 2 ** 15
    read = voxnav.LocalMap.load_octomap(path, m.config, center)
    before, after = m.changes_since(0), read.changes_since(0)
    assert len(before[1]) > 0
    np.testing.assert_array_equal(before[1], after[1])
    np.testing.assert_array_equal(before[2], after[2])
