# SPDX-License-Identifier: BSD-3-Clause
"""The simulated world and LiDAR, through Python, are true to their mesh and repeat exactly."""

import glob
import os

import numpy as np
import pytest

# Only the compiled module may be absent; any other failure to import is an error.
pytest.importorskip("voxnav._simulation", reason="built without Embree")
import voxnav  # noqa: E402
from voxnav import simulation  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
WORLDS = sorted(glob.glob(os.path.join(ROOT, "worlds", "*.yaml")))
CLASSES = simulation.CLASSES


@pytest.fixture(scope="module")
def forest():
    return simulation.World(os.path.join(ROOT, "worlds", "forest.yaml"), seed=3)


@pytest.fixture(scope="module")
def scan(forest):
    lidar = simulation.Lidar(columns=512, sun_half_angle_rad=1.5)
    return lidar.scan(forest, simulation.pose(0, 0, 2.0), simulation.pose(0.3, 0, 2.0, 0.1), scan_index=5)


@pytest.mark.parametrize("path", WORLDS, ids=os.path.basename)
def test_shipped_worlds_name_every_parameter_and_can_be_built(path):
    with open(path) as file:
        keys = [line.split(":")[0] for line in file if line.strip() and not line.startswith("#")]
    assert keys == [field["name"] for field in simulation.WorldConfig.describe()]
    world = simulation.World(path, seed=1)
    asked = world.config.trees_per_ha * np.prod(world.config.size_m) / 1e4
    assert world.counts["trees"] == pytest.approx(asked, abs=0.51)
    assert (world.vehicle_pose() is not None) == world.config.has_vehicle


def test_forest_world_is_the_default_configuration():
    config = simulation._simulation.load_world_config(os.path.join(ROOT, "worlds", "forest.yaml"))
    assert config.to_dict() == simulation.WorldConfig().to_dict()


def test_unknown_and_wrong_parameters_are_all_named():
    with pytest.raises(ValueError) as error:
        simulation.World({"trees_per_hectare": 300.0, "num_poles": -1})
    assert "trees_per_hectare" in str(error.value) and "num_poles = -1" in str(error.value)


def test_ply_holds_the_mesh(forest, tmp_path):
    path = tmp_path / "world.ply"
    forest.save_ply(path)
    header, _, body = path.read_bytes().partition(b"end_header\n")
    assert b"comment seed 3\n" in header
    vertices, triangles, classes = forest.mesh()
    stored = np.frombuffer(body, np.float32, 3 * len(vertices)).reshape(-1, 3)
    np.testing.assert_array_equal(stored, vertices)
    face = np.dtype([("n", "u1"), ("corners", "<u4", 3), ("class", "u1"), ("rgb", "u1", 3)])
    faces = np.frombuffer(body, face, offset=vertices.nbytes)
    np.testing.assert_array_equal(faces["corners"], triangles)
    np.testing.assert_array_equal(faces["class"], classes)


def test_ground_height_takes_numbers_and_arrays(forest):
    assert forest.ground_height(0, 0) == pytest.approx(0.0, abs=1e-9)
    heights = forest.ground_height(np.array([[0.0, 10.0], [1e6, 20.0]]), 0.0)
    assert heights.shape == (2, 2) and np.isnan(heights[1, 0]) and np.isfinite(heights).sum() == 3


def test_stems_stand_on_the_ground(forest):
    trunks, poles = forest.trunks(), forest.poles()
    assert len(trunks) == forest.counts["trees"] and len(poles) == forest.counts["poles"]
    ground = forest.ground_height(trunks.ground[:, 0], trunks.ground[:, 1])
    np.testing.assert_allclose(trunks.ground[:, 2], ground, atol=1e-9)
    assert (trunks.radius_ground_m >= 0.05).all() and (trunks.radius_ground_m <= 0.4).all()
    assert (trunks.top[:, 2] - trunks.ground[:, 2] > 4.0).all()


def test_crowns_and_bushes_let_part_of_the_beams_through(forest):
    trunks = forest.trunks()
    rng = np.random.default_rng(0)
    low = trunks.ground + 0.5 * (trunks.top - trunks.ground)
    start = low + np.column_stack([rng.uniform(-0.8, 0.8, (len(low), 2)), np.full(len(low), 20.0)])
    _, classes, _ = forest.cast(start, np.tile([0.0, 0.0, -1.0], (len(low), 1)))
    stopped = np.mean(classes == CLASSES["foliage"])
    passed = np.mean(classes == CLASSES["terrain"])
    assert stopped > 0.15 and passed > 0.15


def test_returns_lie_on_the_mesh_within_noise(forest):
    lidar = simulation.Lidar(columns=256, range_noise_m=0.02)
    T = simulation.pose(20.0, 3.0, forest.ground_height(20.0, 3.0) + 2.0, 0.4)
    scan = lidar.scan(forest, T)
    is_world = scan.classes < CLASSES["own_body"]
    points = scan.points[is_world, :3].astype(float) @ T[:3, :3].T + T[:3, 3]
    distance = forest.surface_distance(points, 1.0)
    assert len(points) > 5000
    assert np.nanmax(distance) < 3.5 * 0.02 + 1e-3
    assert np.sqrt(np.mean(distance**2)) < 0.02


def test_scan_has_one_entry_per_return(scan):
    assert scan.organised.shape == (128, 512, 4) and scan.organised.dtype == np.float32
    n = np.count_nonzero(scan.ranges_m)
    assert scan.points.shape == (n, 4) and scan.point_times.shape == (n,) and scan.classes.shape == (n,)
    assert not scan.organised[scan.labels == CLASSES["none"]].any()
    assert scan.point_times.max() < 0.1 and scan.point_times.min() == 0.0
    for name in ("terrain", "trunk", "foliage", "own_body", "ghost"):
        assert (scan.classes == CLASSES[name]).any(), name


def test_scans_repeat_exactly_and_differ_by_index(forest):
    lidar = simulation.Lidar(columns=128, model="os1-16")
    T = simulation.pose(0, 0, 2.0)
    first, again, other = lidar.scan(forest, T, T, 1), lidar.scan(forest, T, T, 1), lidar.scan(forest, T, T, 2)
    np.testing.assert_array_equal(first.organised, again.organised)
    assert (first.organised != other.organised).any()


def test_vehicle_moves_for_rays_and_clearance():
    world = simulation.World(os.path.join(ROOT, "worlds", "firetruck.yaml"), seed=1)
    x, y = world.config.vehicle_position_m
    above = np.array([[x, y, world.ground_height(x, y) + 3.8]])
    assert world.clearance(above)[0] < 0.6
    assert world.move_vehicle(x, y + 12.0, 0.3)
    assert world.clearance(above)[0] > 2.0
    assert not world.move_vehicle(1e5, 0.0)


@pytest.mark.parametrize("bad", [np.eye(3), np.eye(4, dtype=np.float32), np.full((4, 4), np.nan)])
def test_scan_refuses_invalid_poses(forest, bad):
    with pytest.raises(ValueError):
        simulation.Lidar(model="os1-16", columns=16).scan(forest, bad)


def test_queries_accept_empty_arrays_and_refuse_nan(forest):
    assert forest.clearance(np.zeros((0, 3))).shape == (0,)
    with pytest.raises(ValueError):
        forest.clearance([[np.nan, 0.0, 0.0]])


def test_shipped_node_parameters_are_the_defaults():
    yaml = pytest.importorskip("yaml")
    with open(os.path.join(ROOT, "config", "lidar_simulator.yaml")) as file:
        shipped = yaml.safe_load(file)
    assert sorted(shipped) == ["lidar", "node", "time"]
    assert shipped["lidar"] == simulation.LidarConfig().to_dict()
    assert shipped["node"] == simulation._simulation.LidarSimulatorConfig().to_dict()
    assert shipped["time"] == voxnav.TimeConfig().to_dict()


def test_persons_walk_and_are_seen_where_they_are():
    fields = {"trees_per_ha": 0.0, "bushes_per_ha": 0.0, "rocks_per_ha": 0.0, "num_poles": 0, "num_walls": 0,
              "num_houses": 0, "terrain_amplitude_m": 0.0, "terrain_roughness_m": 0.0,
              "walker_waypoints": [0, 8.0, -3.0, 0, 8.0, 3.0]}
    world = simulation.World(fields, seed=1)
    assert np.allclose(world.movers(0.0), [[8.0, -3.0, 0.0, 0.25, 1.75, CLASSES["person"]]])
    assert np.allclose(world.movers(2.0)[0, :2], (8.0, -0.2))
    assert np.allclose(world.clearance([(8.0, -2.0, 1.0)], stamp_s=0.0), 0.75)
    assert np.allclose(world.clearance([(8.0, -2.0, 1.0)]), 1.0), "without a time there are no persons"
    lidar = simulation.Lidar(columns=512, dropout_ratio=0.0)
    for index in (0, 20):
        scan = lidar.scan(world, simulation.pose(0, 0, 1.0), simulation.pose(0, 0, 1.0), scan_index=index)
        persons = scan.organised[scan.labels == CLASSES["person"]][:, :2]
        # The beams that look ahead are those in the middle of a turn.
        assert len(persons) > 20
        assert np.linalg.norm(persons.mean(axis=0) - world.movers(0.1 * index + 0.05)[0, :2]) < 0.35
    with pytest.raises(voxnav.ConfigError, match="walker_waypoints"):
        simulation.World(dict(fields, walker_waypoints=[0, 8.0]))
