# SPDX-License-Identifier: BSD-3-Clause
"""Names of maps stay in their folder, versions replace each other whole, and loaded maps find the ground."""

import os

import numpy as np
import pytest

import voxnav
from voxnav.octomap_face import MapNameError, ground_height_m, map_path, offset_m
from voxnav.octomap_face.map_names import backup_path, known_names, replace_with_backup, unfinished_path

VOXEL = 0.4


def test_a_name_is_a_file_in_the_folder(tmp_path):
    assert map_path(str(tmp_path), "hall_2-b") == str(tmp_path / "hall_2-b.ot")
    assert map_path("~", "hall") == os.path.join(os.path.realpath(os.path.expanduser("~")), "hall.ot")


@pytest.mark.parametrize("name", ["", ".", "..", "../a", "a/b", "/etc/passwd", "a.ot", "-a", "a b", "a\0b", "ä", "a\n",
                                  "x" * 101])
def test_what_could_leave_the_folder_is_no_name(tmp_path, name):
    with pytest.raises(MapNameError, match="is no name of a map"):
        map_path(str(tmp_path), name)


def test_links_are_not_followed(tmp_path):
    (tmp_path / "maps").mkdir()
    (tmp_path / "other.ot").write_bytes(b"")
    (tmp_path / "maps" / "hall.ot").symlink_to(tmp_path / "other.ot")
    with pytest.raises(MapNameError, match="is a link"):
        map_path(str(tmp_path / "maps"), "hall")


def test_the_last_version_is_kept(tmp_path):
    path = map_path(str(tmp_path), "hall")
    for text in ("first", "second", "third"):
        with open(unfinished_path(path), "w") as out:
            out.write(text)
        replace_with_backup(unfinished_path(path), path)
    assert open(path).read() == "third" and open(backup_path(path)).read() == "second"
    assert known_names(str(tmp_path)) == ["hall", "hall_backup"]
    assert known_names(str(tmp_path / "nowhere")) == []


def saved(tmp_path, surfaces):
    """Returns the path of an OctoMap with occupied voxels at (x, y, z)."""
    local = voxnav.LocalMap(voxnav.LocalMapConfig(resolution_m=VOXEL))
    for _ in range(4):
        local.insert(np.array(surfaces, dtype=np.float32), np.eye(4))
    path = str(tmp_path / "map.ot")
    local.save_octomap(path)
    return path


def plane(z, half=4.0):
    x, y = np.meshgrid(np.arange(-half, half, VOXEL), np.arange(-half, half, VOXEL))
    return [(a + 0.2, b + 0.2, z) for a, b in zip(x.ravel(), y.ravel())]


def test_the_ground_is_found_below_trees_and_beside_walls(tmp_path):
    crown = [(x, y, 6.0) for x, y, _ in plane(0.0, 1.6)]
    wall = [(1.8, 0.2, z) for z in np.arange(-3.0, 5.0, VOXEL)]
    path = saved(tmp_path, plane(-3.0) + crown + wall)
    assert ground_height_m(path, (0.0, 0.0, 0.0), 2.0) == pytest.approx(-3.0, abs=0.5 * VOXEL)


def test_no_ground_is_none(tmp_path):
    path = saved(tmp_path, plane(-3.0))
    assert ground_height_m(path, (50.0, 0.0, 0.0), 2.0) is None
    with pytest.raises(RuntimeError, match="cannot be opened"):
        ground_height_m(str(tmp_path / "none.ot"), (0.0, 0.0, 0.0), 2.0)


def test_a_map_rises_to_where_the_ground_is():
    assert offset_m(ground_m=-3.0, body_z_m=0.0, height_m=None, robot_height_m=0.3) == pytest.approx(2.7)
    assert offset_m(ground_m=-3.0, body_z_m=5.0, height_m=8.0, robot_height_m=0.3) == pytest.approx(0.0)
