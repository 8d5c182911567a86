# SPDX-License-Identifier: BSD-3-Clause
import subprocess
import sys

import numpy as np
import pytest

import voxnav

VOXEL = 0.4


def scene(with_box=True):
    """Returns (states, origin) of ground that was seen from above, with or without a box on it."""
    states = np.ones((40, 40, 16), np.int8)
    states[:, :, 0] = 2
    if with_box:
        states[15:20, 15:20, 1:6] = 2
    return states, (-8.0, -8.0, 0.0)


def pose(x=0.0, y=0.0, z=0.0, yaw=0.0):
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T[:3, 3] = x, y, z
    return T


def submap(with_box=True, T_S_G=None, **config):
    states, origin = scene(with_box)
    content = voxnav.map_content_from_array(states, origin, VOXEL)
    return voxnav.Submap.from_content(content, np.eye(4) if T_S_G is None else T_S_G, voxnav.SubmapConfig(**config))


def test_distance_of_free_voxels_equals_brute_force():
    states, origin = scene()
    centers = (np.argwhere(states == 1)[::37] + 0.5) * VOXEL + origin
    surface = (np.argwhere(states == 2) + 0.5) * VOXEL + origin
    truth = np.linalg.norm(centers[:, None] - surface[None], axis=2).min(axis=1)
    measured = submap().distance(np.ascontiguousarray(centers, np.float32))
    assert measured.dtype == np.float64
    np.testing.assert_allclose(measured, np.minimum(truth, 10.0), atol=0.006)


def test_distance_is_nan_where_unobserved():
    points = np.array([[100, 0, 0], [0, 0, -3], [np.nan, 0, 0]], np.float32)
    assert np.isnan(submap().distance(points)).all()
    assert np.isnan(submap().gradient(points)).all()


def test_queries_refuse_wrong_arrays():
    with pytest.raises(ValueError, match="float32"):
        submap().distance(np.zeros((3, 3)))
    with pytest.raises(ValueError):
        submap().distance(np.zeros((3, 2), np.float32))


def test_certified_is_never_above_the_distance_to_occupied_voxels():
    states, origin = scene()
    low = np.argwhere(states == 2) * VOXEL + origin
    points = np.random.RandomState(1).uniform((-8, -8, 0), (8, 8, 6), (500, 3)).astype(np.float32)
    nearest = np.clip(points[:, None], low[None], low[None] + VOXEL)
    truth = np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)
    assert (submap(certified=True).distance(points) <= truth + 1e-6).all()


def test_submap_frame_moves_everything():
    T_S_G = pose(5, -3, 1, 0.5)
    moved, plain = submap(T_S_G=T_S_G), submap()
    points = np.random.RandomState(1).uniform((-8, -8, 0), (8, 8, 6), (300, 3))
    in_S = points @ T_S_G[:3, :3].T + T_S_G[:3, 3]
    np.testing.assert_allclose(
        moved.distance(in_S.astype(np.float32)), plain.distance(points.astype(np.float32)), atol=1e-4
    )
    assert len(moved.occupied_points()) == (scene()[0] == 2).sum()


def test_bytes_round_trip_and_refusal():
    original = submap()
    data = original.to_bytes()
    copy = voxnav.Submap.from_bytes(data)
    assert copy.to_bytes() == data
    for broken in (data[:-1], data[: len(data) // 2], b"", data[:50] + b"\x07" + data[51:]):
        with pytest.raises(ValueError, match="submap"):
            voxnav.Submap.from_bytes(broken)


def test_mesh_of_a_submap_has_valid_triangles():
    vertices, triangles = submap().mesh()
    assert vertices.dtype == np.float32 and triangles.dtype == np.uint32
    assert triangles.max() < len(vertices)


def test_bad_configuration_raises_config_error():
    with pytest.raises(voxnav.ConfigError, match="band_voxels"):
        voxnav.SubmapConfig(band_voxels=1.0)
    with pytest.raises(voxnav.ConfigError, match="rule"):
        voxnav.ProjectiveConfig(rule="quick")
    with pytest.raises(voxnav.ConfigError, match="truncation_m"):
        voxnav.ProjectiveIntegrator(voxnav.ProjectiveConfig(truncation_m=0.5))


def test_projective_integrator_finds_a_wall():
    integrator = voxnav.ProjectiveIntegrator(voxnav.ProjectiveConfig(rule="merged"))
    y, z = np.meshgrid(np.arange(-4, 4, 0.1), np.arange(-2, 2, 0.1))
    wall = np.column_stack([np.full(y.size, 5.03), y.ravel(), z.ravel()]).astype(np.float32)
    counts = integrator.integrate(wall, np.eye(4))
    assert counts["rays"] < counts["points"] and counts["dropped"] == 0
    u = integrator.finish()
    np.testing.assert_allclose(u.surface_points()[:, 0], 5.03, atol=0.15)


def test_collection_removes_a_box_that_newer_submaps_saw_through_and_keeps_the_rest():
    c = voxnav.SubmapCollection()
    c.add(1, submap(True), np.eye(4), stamp=10.0)
    before = c.occupied_points()
    c.add(2, submap(False), pose(0.05, 0.0, 0.02), stamp=20.0)
    after = c.occupied_points()
    assert (before[:, 2] > 0.6).sum() > 50
    assert (after[:, 2] > 0.6).sum() == 0
    assert (after[:, 2] < 0.4).sum() > 1400


def test_obstacles_equal_brute_force():
    c = voxnav.SubmapCollection()
    c.add(1, submap(), pose(1, 2, 3, 0.7))
    points = c.occupied_points()
    grid = c.obstacle_grid(1.5)
    centers = np.concatenate([grid.centers(1), grid.centers(2)])[::31].copy()
    nearest = np.linalg.norm(centers[:, None] - points[None], axis=2).min(axis=1)
    reach = 1.5 + 0.5 * np.sqrt(3) * VOXEL
    clear = np.abs(nearest - reach) > 1e-4
    np.testing.assert_array_equal((grid.states(centers) == 2)[clear], (nearest < reach)[clear])
    assert len(c.obstacles(1.5)) == len(grid.centers(2))


def test_obstacle_changes_add_up_to_the_grid():
    c = voxnav.SubmapCollection()
    obstacles = voxnav.ObstacleMap(VOXEL, 1.0)
    received = voxnav.StateGrid(VOXEL)
    c.add(1, submap(), np.eye(4))
    received.apply_update(**obstacles.update(c))
    c.set_poses({1: pose(3, 0, 0, 0.2)})
    received.apply_update(**obstacles.update(c))
    points = np.random.RandomState(1).uniform((-10, -10, -2), (10, 10, 6), (3000, 3)).astype(np.float32)
    np.testing.assert_array_equal(received.states(points), c.obstacle_grid(1.0).states(points))


def test_bends_are_set_with_poses_and_reset_by_poses_without_them():
    c, bend = voxnav.SubmapCollection(), np.array([pose(0.3, 0, 0, 0), pose(0, -0.2, 0, 0)])
    c.add(1, submap(), np.eye(4), bend=bend)
    np.testing.assert_array_equal(c.bends()[1], bend)
    c.set_poses({1: np.eye(4)})
    np.testing.assert_array_equal(c.bends()[1], [np.eye(4)] * 2)
    c.set_poses({1: np.eye(4)}, {1: bend, 2: bend})
    np.testing.assert_array_equal(c.bends()[1], bend)
    with pytest.raises(ValueError, match="bend"):
        c.set_poses({1: np.eye(4)}, {1: bend[0]})
    field = submap().registration_field()
    shift = field.bent_surface_points(np.array([pose(0, 0, 0, 0), pose(4.0, 0, 0, 0)])) - field.surface_points()
    assert np.all((shift[:, 0] > -1e-5) & (shift[:, 0] < 0.1))  # points of unknown time count as seen in the middle


def test_collection_save_and_load(tmp_path):
    c = voxnav.SubmapCollection()
    c.add(7, submap(), pose(1, 2, 3, 0.1), stamp=3.0)
    c.save(str(tmp_path / "map"))
    copy = voxnav.SubmapCollection.load(str(tmp_path / "map"))
    np.testing.assert_array_equal(copy.occupied_points(), c.occupied_points())
    np.testing.assert_array_equal(copy.poses()[7], c.poses()[7])
    index = tmp_path / "map" / "index.vxi"
    index.write_bytes(index.read_bytes()[:-3])
    with pytest.raises(ValueError, match="index.vxi"):
        voxnav.SubmapCollection.load(str(tmp_path / "map"))


def test_from_local_map_keeps_every_surface_of_the_map():
    m = voxnav.LocalMap(voxnav.LocalMapConfig(resolution_m=VOXEL))
    rng = np.random.RandomState(2)
    xy = rng.uniform(-6, 6, (4000, 2))
    scan = np.column_stack([xy, np.full(len(xy), -2.0)]).astype(np.float32)
    for _ in range(4):
        m.insert(scan, pose(0, 0, 3))
    T_W_S = pose(1, -2, 3, 0.4)
    u = voxnav.Submap.from_local_map(m, T_W_S)
    in_W = m.occupied_points()
    assert len(in_W) > 500
    in_S = ((in_W - T_W_S[:3, 3]) @ T_W_S[:3, :3]).astype(np.float32)
    assert len(u.occupied_points()) == len(in_W)
    assert (u.states(np.ascontiguousarray(in_S)) == 2).mean() > 0.99
    distance = u.distance(np.ascontiguousarray(in_S))
    assert np.abs(distance).max() < 1.5 * VOXEL
    on_surface = u.distance(u.surface_points())
    assert np.abs(on_surface).max() < 0.5 * VOXEL and np.abs(on_surface.mean()) < 0.1 * VOXEL


def test_queries_over_all_submaps():
    c = voxnav.SubmapCollection()
    c.add(1, submap(), np.eye(4))
    c.add(2, submap(), pose(30, 0, 0))
    points = np.array([[0.2, 0.2, 5.0], [30.2, 0.2, 5.0], [100, 0, 0]], np.float32)
    gradient = c.gradient(points)
    np.testing.assert_allclose(gradient[:2, 2], 1.0, atol=0.1)
    assert np.isnan(gradient[2]).all()
    state, distance = c.cast_ray((-5.0, -1.0, 1.4), (5.0, -1.0, 1.4))
    assert state == 2 and abs(distance - 3.0) < 0.41
    assert c.cast_ray((-5.0, 0.0, 5.0), (5.0, 0.0, 5.0)) == (1, 10.0)
    assert c.cast_ray((-5.0, 0.0, 5.0), (-50.0, 0.0, 5.0))[0] == 0


def test_a_box_that_disappeared_is_listed_as_a_change():
    c = voxnav.SubmapCollection()
    c.add(1, submap(True), np.eye(4), stamp=1.0)
    c.add(2, submap(False), pose(0.02, 0.03, 0.0), stamp=2.0)
    (change,) = c.changes()
    assert change["kind"] == "disappeared" and change["submap"] == 2 and change["voxels"] > 50
    np.testing.assert_allclose(change["center"], (-1.0, -1.0, 1.4), atol=0.5)


def test_two_flights_are_merged():
    a, b = voxnav.SubmapCollection(), voxnav.SubmapCollection()
    a.add(3, submap(), np.eye(4))
    b.add(3, submap(), pose(1, 0, 0))
    assert a.merge(b, pose(50, 0, 0)) == 4
    np.testing.assert_allclose(a.poses()[7][:3, 3], (51, 0, 0))
    assert len(a.occupied_points()) == 2 * len(b.occupied_points())


def test_a_bounded_share_of_the_map_stays_in_memory(tmp_path):
    config = voxnav.SubmapCollectionConfig(page_dir=str(tmp_path), max_resident_mb=1.0)
    paged, whole = voxnav.SubmapCollection(config), voxnav.SubmapCollection()
    data = submap().to_bytes()
    for i in range(200):
        for c in (paged, whole):
            c.add(i, voxnav.Submap.from_bytes(data), pose(20 * i, 0, 0))
            c.states(np.zeros((1, 3), np.float32))  # a query merges the submaps that are new
    assert paged.num_resident < 200 == whole.num_resident
    np.testing.assert_array_equal(paged.occupied_points(), whole.occupied_points())


SAVER = """
import sys, voxnav
c = voxnav.SubmapCollection.load(sys.argv[1])
while True:
    c.save(sys.argv[1])
    print(len(c), flush=True)
    c.add(len(c) + 1, c.submap(1), c.poses()[1], stamp=float(len(c)))
"""


@pytest.mark.parametrize("saves", [1, 2, 5, 9])
def test_a_process_that_is_killed_while_saving_leaves_a_complete_map(tmp_path, saves):
    directory = str(tmp_path / "map")
    c = voxnav.SubmapCollection()
    c.add(1, submap(), pose(1, 2, 3, 0.1))
    c.save(directory)
    saver = subprocess.Popen([sys.executable, "-c", SAVER, directory], stdout=subprocess.PIPE)
    for _ in range(saves):
        done = int(saver.stdout.readline())
    saver.kill()
    saver.wait()
    saver.stdout.close()
    copy = voxnav.SubmapCollection.load(directory)
    assert len(copy) >= done
    np.testing.assert_array_equal(copy.submap(1).occupied_points(), c.submap(1).occupied_points())


def test_exports_hold_every_surface_point(tmp_path):
    c = voxnav.SubmapCollection()
    c.add(3, submap(), pose(1, 2, 3, 0.5), stamp=12.5)
    c.save_clouds(str(tmp_path))
    header, _, body = (tmp_path / "submap_000003.ply").read_bytes().partition(b"end_header\n")
    assert b"element vertex %d\n" % len(c.submap(3).occupied_points()) in header
    np.testing.assert_array_equal(np.frombuffer(body, "<f4").reshape(-1, 3), c.submap(3).occupied_points())
    row = np.loadtxt(str(tmp_path / "poses.txt"))
    np.testing.assert_allclose(row, (3, 12.5, 1, 2, 3, 0, 0, np.sin(0.25), np.cos(0.25)), atol=1e-6)
    c.save_octomap(str(tmp_path / "map.bt"))
    assert (tmp_path / "map.bt").read_bytes().startswith(b"# Octomap OcTree binary file")
    with pytest.raises(ValueError, match="ends in"):
        c.save_octomap(str(tmp_path / "map.xyz"))


def test_octomap_of_a_merged_map_far_from_the_origin_states_its_shift(tmp_path):
    near, far = voxnav.SubmapCollection(), voxnav.SubmapCollection()
    near.add(3, submap(), pose(0, 0, 0))
    far.add(3, submap(), pose(500000.0, -40000.0, 0))  # shifted by whole voxels
    assert near.save_octomap(str(tmp_path / "near.ot")) is None
    with pytest.warns(UserWarning, match="was shifted; add"):
        shift = far.export(str(tmp_path))
    config = voxnav.LocalMapConfig(resolution_m=VOXEL, window_size_m=(60, 60, 30))
    read = [voxnav.LocalMap.load_octomap(str(tmp_path / name), config, center)
            for name, center in (("near.ot", (0, 0, 0)), ("map.ot", (500000.0, -40000.0, 0)))]
    assert len(shift) == 3 and shift[0] > 400000 and shift[1] < -30000 and shift[2] == 0
    assert len(read[0].occupied_centers()) > 0
    for centers in (voxnav.LocalMap.occupied_centers, voxnav.LocalMap.free_centers):
        moved = centers(read[1]).astype(float) - (500000.0, -40000.0, 0)
        np.testing.assert_allclose(np.sort(moved, axis=0), np.sort(centers(read[0]), axis=0), atol=0.1)


def occupied_cells(collection):
    return {tuple(cell) for cell in np.floor(collection.occupied_points() / VOXEL).astype(int)}


def test_an_octomap_of_the_merged_map_is_loaded_again(tmp_path):
    """What OctoMap keeps comes back: every occupied and every free voxel, also across the borders of submaps."""
    saved = voxnav.SubmapCollection()
    saved.add(0, submap(), pose())
    saved.add(1, submap(False), pose(80.0, -40.0, 1.2))
    path = str(tmp_path / "map.ot")
    assert saved.save_octomap(path) is None
    loaded = voxnav.SubmapCollection.load_octomap(path, voxnav.SubmapCollectionConfig(resolution_m=VOXEL))
    assert len(loaded) == 5  # the first one lies on the corner of four tiles, the second one on an edge
    assert occupied_cells(loaded) == occupied_cells(saved)
    x, y, z = np.meshgrid(np.arange(-12, 92, 0.8), np.arange(-52, 12, 0.8), np.arange(-1, 8, 0.4))
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1).astype(np.float32) + 0.1
    assert set(np.unique(saved.states(points))) == {0, 1, 2}
    np.testing.assert_array_equal(loaded.states(points), saved.states(points))


def test_an_octomap_that_is_none_or_of_another_resolution_is_refused(tmp_path):
    saved = voxnav.SubmapCollection()
    saved.add(0, submap(), pose())
    path = str(tmp_path / "map.ot")
    saved.save_octomap(path)
    with pytest.raises(RuntimeError, match="map.ot: it has voxels of 0.4.* m, and this map has voxels of 0.2"):
        voxnav.SubmapCollection.load_octomap(path, voxnav.SubmapCollectionConfig(resolution_m=0.2))
    with open(path, "r+b") as broken:
        broken.truncate(500)
    with pytest.raises(RuntimeError, match="map.ot.*in the middle of its nodes"):
        voxnav.SubmapCollection.load_octomap(path)
    with pytest.raises(RuntimeError, match="cannot be opened"):
        voxnav.SubmapCollection.load_octomap(str(tmp_path / "none.ot"))
