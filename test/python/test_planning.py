# SPDX-License-Identifier: BSD-3-Clause
"""The path search, the corridor check and the navigation map work through Python as documented."""

import pathlib

import numpy as np
import pytest
import yaml

import voxnav

CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config" / "planning_manager.yaml"


def free_grid(shape=(40, 20, 10), origin=(0.0, 0.0, 0.0), resolution_m=0.4):
    return voxnav.StateGrid.from_array(np.ones(shape, dtype=np.int8), origin, resolution_m)


def test_plan_returns_a_named_status_and_a_path_of_cell_centres():
    planner = voxnav.AStarPlanner(voxnav.AStarConfig(safety_distance_m=0.0))
    result = planner.plan(free_grid(), (0.2, 0.2, 0.2), (10.2, 0.2, 0.2))
    assert result.status == "complete" and not result.partial
    assert result.path.shape == (26, 3) and result.path.dtype == np.float64
    assert np.allclose(result.path[-1], (10.2, 0.2, 0.2))
    assert result.cost_m == pytest.approx(10.0)
    assert result.expansions == 26 and result.seconds > 0.0 and result.memory_bytes > 0


def test_plan_answers_bad_positions_and_refuses_bad_arguments():
    planner = voxnav.AStarPlanner()
    result = planner.plan(free_grid(), (float("nan"), 0.0, 0.0), (1.0, 1.0, 1.0))
    assert result.status == "invalid_input" and result.path.shape == (0, 3)
    assert planner.plan(free_grid(), (4.2, 4.2, 2.2), (1e9, 0.0, 0.0)).status == "outside_map"
    with pytest.raises(ValueError, match="three numbers"):
        planner.plan(free_grid(), (0.0, 0.0), (1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match="view must be"):
        planner.plan(np.zeros(3), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    with pytest.raises(voxnav.ConfigError, match="unknown_policy"):
        voxnav.AStarConfig(unknown_policy="hope")


@pytest.mark.parametrize("goal", [(30.0, 10.0, 4.0), (500.0, 10.0, 4.0), (30.0, 10.0, -30.0)],
                         ids=["inside a tree", "outside the window", "under the ground"])
def test_goals_that_cannot_be_reached_are_answered_within_the_limits(goal):
    states = np.ones((200, 50, 25), dtype=np.int8)
    states[:, :, 0:2] = 2
    states[72:79, 22:29, :] = 2
    grid = voxnav.StateGrid.from_array(states, (0.0, 0.0, 0.0), 0.4)
    config = voxnav.AStarConfig(safety_distance_m=0.8, timeout_s=30.0, max_memory_mib=64.0)
    result = voxnav.AStarPlanner(config).plan(grid, (4.0, 10.0, 4.0), goal)
    assert result.status in ("goal_blocked", "outside_map")
    assert result.partial and len(result.path) > 10
    assert result.memory_bytes <= 64 * 2 ** 20 and result.expansions < 100000


def test_corridor_lets_only_known_free_space_pass():
    states = np.ones((40, 20, 20), dtype=np.int8)
    states[25, 10, 10] = 0
    grid = voxnav.StateGrid.from_array(states, (0.0, 0.0, 0.0), 0.4)
    line = np.array([[2.0, 4.2, 4.2], [14.0, 4.2, 4.2]])
    result = voxnav.check_corridor(grid, line, 0.5)
    assert not result.safe and result.unsafe_state == 0
    assert result.first_unsafe_m == pytest.approx(8.0 - 0.5)
    assert voxnav.check_corridor(grid, line, 0.5, allow_unknown=True).safe
    with pytest.raises(ValueError, match="points"):
        voxnav.check_corridor(grid, line.astype(np.float32), 0.5)


def test_clearance_field_knows_distances_and_what_is_connected():
    states = np.ones((64, 32, 16), dtype=np.int8)
    states[30] = 2
    field = voxnav.ClearanceField(voxnav.ClearanceFieldConfig(safety_distance_m=0.8, radius_m=3.0))
    points = np.array([[10.0, 6.2, 3.0], [20.0, 6.2, 3.0], [11.8, 6.2, 3.0], [np.nan, 0.0, 0.0]], dtype=np.float32)
    assert list(field.components(points)) == [0, 0, 0, 0]
    field.update(voxnav.StateGrid.from_array(states, (0.0, 0.0, 0.0), 0.4))
    assert field.clearance(points)[:3] == pytest.approx([2.0, 3.0, 0.2], abs=1e-5)
    assert np.isnan(field.clearance(points)[3])
    left, right, wall, nowhere = field.components(points)
    assert left != 0 and right != 0 and left != right and wall == 0 and nowhere == 0
    states[30, 10:20, 4:12] = 1
    grid = voxnav.StateGrid.from_array(states, (0.0, 0.0, 0.0), 0.4)
    assert field.update(grid).changed_blocks == 2
    assert field.update(grid).recomputed_blocks == 0
    left, right = field.components(points)[:2]
    assert left == right != 0
    assert field.memory_bytes > 0 and field.resolution_m == 0.4
    with pytest.raises(ValueError, match="safety_distance_m 8.00 is more than 16 voxels"):
        voxnav.ClearanceField(voxnav.ClearanceFieldConfig(safety_distance_m=8.0, radius_m=8.0)).update(grid)
    with pytest.raises(voxnav.ConfigError, match="radius_m"):
        voxnav.ClearanceField(voxnav.ClearanceFieldConfig(radius_m=0.5, safety_distance_m=1.0))


def test_on_a_fine_map_distances_are_kept_as_far_as_the_field_can():
    states = np.ones((128, 64, 32), dtype=np.int8)
    states[60] = 2
    field = voxnav.ClearanceField(voxnav.FlightSearchConfig().field_config())
    field.update(voxnav.StateGrid.from_array(states, (0.0, 0.0, 0.0), 0.1))
    planner = voxnav.PathPlanner(voxnav.FlightSearchConfig().planner_config())
    plan = planner.plan(field, (1.0, 3.0, 1.6), (4.5, 3.0, 1.6))
    assert plan.status == "complete" and plan.cost_m >= plan.length_m == pytest.approx(3.5, abs=0.01)


def divided_field():
    """Two rooms with a door high up in the wall between them, and a closed box."""
    states = np.ones((64, 32, 16), dtype=np.int8)
    states[30] = 2
    states[30, 10:20, 8:16] = 1
    states[48:56, 20:28, 4:12] = 2
    states[49:55, 21:27, 5:11] = 1
    field = voxnav.ClearanceField(voxnav.ClearanceFieldConfig(safety_distance_m=0.8))
    field.update(voxnav.StateGrid.from_array(states, (0.0, 0.0, 0.0), 0.4))
    return field


def test_path_planner_leads_through_the_door_with_exact_clearance():
    field = divided_field()
    start, goal = (2.0, 2.0, 1.4), (22.0, 3.0, 1.4)
    plan = voxnav.PathPlanner().plan(field, start, goal)
    assert plan.status == "complete" and not plan.partial and plan.reason
    assert np.allclose(plan.path[0], start) and np.allclose(plan.path[-1], goal)
    assert plan.path.dtype == np.float64 and 3 <= len(plan.path) < 20
    steps = np.linalg.norm(np.diff(plan.path, axis=0), axis=1)
    assert plan.length_m == pytest.approx(steps.sum()) == plan.cost_m
    samples = np.concatenate([np.linspace(a, b, 200) for a, b in zip(plan.path, plan.path[1:])]).astype(np.float32)
    assert field.clearance(samples).min() >= 0.8 - 1e-5
    assert plan.lower_bound_m <= plan.length_m * 1.09 and plan.expansions > 0 and plan.seconds > 0.0


@pytest.mark.parametrize("goal, status", [((20.8, 9.6, 3.2), "goal_enclosed"), ((12.2, 1.0, 1.0), "goal_blocked"),
                                          ((np.nan, 1.0, 1.0), "invalid_input")],
                         ids=["closed box", "wall", "not a number"])
def test_path_planner_knows_that_a_goal_cannot_be_reached_without_a_search(goal, status):
    planner = voxnav.PathPlanner(voxnav.PathPlannerConfig(goal_search_radius_m=0.0))
    plan = planner.plan(divided_field(), (2.0, 2.0, 1.4), goal)
    assert plan.status == status and plan.expansions == 0 and plan.path.shape == (0, 3)


def test_path_planner_leads_near_a_goal_that_is_blocked():
    plan = voxnav.PathPlanner().plan(divided_field(), (2.0, 2.0, 1.4), (12.2, 4.0, 1.4))
    assert plan.status == "goal_blocked" and plan.partial
    assert 0.5 < plan.remaining_m < 2.0 and len(plan.path) >= 2
    plan = voxnav.PathPlanner().plan(divided_field(), (2.0, 2.0, 1.4), (200.0, 2.2, 1.4))
    assert plan.status == "outside_map" and plan.partial
    assert np.allclose(plan.path[-1], (25.4, 2.2, 1.4)), "to the edge of the map"
    few = voxnav.PathPlanner(voxnav.PathPlannerConfig(max_expansions=10))
    plan = few.plan(divided_field(), (2.0, 2.0, 1.4), (22.0, 3.0, 1.4))
    assert plan.status == "partial_limit"
    with pytest.raises(ValueError, match="radius_m"):
        voxnav.PathPlanner(voxnav.PathPlannerConfig(clearance_distance_m=5.0)).plan(
            divided_field(), (2.0, 2.0, 1.4), (22.0, 3.0, 1.4))


def navigation_map(**config):
    """Returns a navigation map whose local map is a free box of 16 m around the origin of O, with the vehicle in it."""
    nav = voxnav.NavigationMap(voxnav.NavigationMapConfig(**config))
    local = free_grid((40, 40, 40), (-8.0, -8.0, -8.0))
    assert nav.view() is None
    assert nav.apply_local(1, 0.4, **local.snapshot()) == voxnav.Applied.APPLIED
    nav.set_vehicle((0.0, 0.0, 0.0))
    assert nav.view() is None
    nav.set_T_W_O(np.eye(4))
    return nav


def states_of(view, *points):
    return list(view.states(np.array(points, dtype=np.float32)))


def test_navigation_map_frees_only_unknown_space_around_the_vehicle():
    nav = navigation_map(footprint_radius_m=1.0, footprint_half_height_m=1.0)
    states = np.ones((40, 40, 40), dtype=np.int8)
    states[18:22, 18:22, 18:22] = 0
    states[20, 20, 20] = 2
    states[30:, :, :] = 0
    grid = voxnav.StateGrid.from_array(states, (-8.0, -8.0, -8.0), 0.4)
    assert nav.apply_local(2, 0.4, **grid.snapshot()) == voxnav.Applied.APPLIED
    assert states_of(nav.view(), (-0.2, -0.2, -0.2), (0.2, 0.2, 0.2), (6.0, 0.0, 0.0)) == [1, 2, 0]


def test_navigation_map_changes_follow_each_other_without_a_gap():
    nav = navigation_map()
    empty = dict(block_indices=np.zeros((0, 3), dtype=np.int32), states=b"", is_snapshot=False)
    gone = np.array([[0, 0, 0]], dtype=np.int32)
    assert nav.apply_local(2, 0.4, removed=gone, **empty) == voxnav.Applied.APPLIED
    assert states_of(nav.view(), (3.0, 3.0, 3.0), (-3.0, 3.0, 3.0)) == [0, 1]
    assert nav.apply_local(2, 0.4, removed=gone, **empty) == voxnav.Applied.IGNORED
    assert nav.apply_local(5, 0.4, removed=gone, **empty) == voxnav.Applied.NEEDS_SNAPSHOT
    assert nav.apply_local(3, 0.2, removed=gone, **empty) == voxnav.Applied.NEEDS_SNAPSHOT
    answers = [nav.apply_local(1, 0.4, removed=gone, **empty) for _ in range(10)]
    assert answers[0] == voxnav.Applied.IGNORED
    assert answers[-1] == voxnav.Applied.NEEDS_SNAPSHOT, "a source that starts anew is noticed"
    with pytest.raises(ValueError):
        nav.apply_local(3, 0.4, block_indices=np.array([[0, 0, 0]], dtype=np.int32), states=b"123",
                        removed=gone, is_snapshot=False)


def test_navigation_views_are_snapshots():
    nav = navigation_map()
    before = nav.view()
    nav.apply_local(2, 0.4, block_indices=np.zeros((0, 3), dtype=np.int32), states=b"",
                    removed=np.array([[0, 0, 0]], dtype=np.int32), is_snapshot=False)
    assert states_of(before, (3.0, 3.0, 3.0)) == [1]
    assert states_of(nav.view(), (3.0, 3.0, 3.0)) == [0]


def test_obstacles_of_the_global_map_move_with_the_correction_and_give_way_to_local_knowledge():
    def far_side(nav, goal=(7.0, 0.2, 0.2)):
        config = voxnav.AStarConfig(safety_distance_m=0.6, clearance_distance_m=0.0, goal_search_radius_m=0.0)
        return voxnav.AStarPlanner(config).plan(nav.view(), (0.2, 0.2, 0.2), goal)

    wall = np.ones((5, 60, 60), dtype=np.int8) * 2
    obstacles = voxnav.StateGrid.from_array(wall, (12.0, -12.0, -12.0), 0.4)
    nav = navigation_map(local_knows_better=False, min_altitude_m=-20.0)
    nav.apply_obstacles(1, 0.4, **obstacles.snapshot())
    assert far_side(nav).status == "complete"
    T_W_O = np.eye(4)
    T_W_O[0, 3] = 8.8  # with this correction the wall is at x = 3.2 m in O
    nav.set_T_W_O(T_W_O)
    assert far_side(nav).status == "partial_blocked"
    nav = navigation_map(local_knows_better=True, min_altitude_m=-20.0)
    nav.apply_obstacles(1, 0.4, **obstacles.snapshot())
    nav.set_T_W_O(T_W_O)
    assert far_side(nav).status == "complete", "the local map sees free space all around: the wall is gone"


def test_altitude_limits_hold_in_the_map_frame():
    nav = navigation_map(min_altitude_m=1.0, max_altitude_m=20.0)
    T_W_O = np.eye(4)
    T_W_O[2, 3] = 2.0  # the origin of O is 2 m above the origin of the map frame
    nav.set_T_W_O(T_W_O)
    config = voxnav.AStarConfig(safety_distance_m=0.0, goal_search_radius_m=0.0)
    planner = voxnav.AStarPlanner(config)
    assert planner.plan(nav.view(), (0.2, 0.2, 0.2), (5.0, 0.2, -0.6)).status == "complete"
    assert planner.plan(nav.view(), (0.2, 0.2, 0.2), (5.0, 0.2, -1.8)).status in ("goal_blocked", "outside_map")


def test_local_map_and_submap_collection_are_views():
    local = voxnav.LocalMap(voxnav.LocalMapConfig(resolution_m=0.4, window_size_m=(40, 40, 20), max_range_m=15.0))
    angles = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    ring = np.stack([10.0 * np.cos(angles), 10.0 * np.sin(angles)], axis=1)
    points = np.concatenate([np.c_[ring, np.full(720, z)] for z in np.arange(-3.0, 3.0, 0.15)]).astype(np.float32)
    for _ in range(5):
        local.insert(points, np.eye(4))
    planner = voxnav.AStarPlanner(voxnav.AStarConfig(safety_distance_m=0.8))
    inside = planner.plan(local, (0.1, 0.1, 0.1), (7.0, 3.0, 0.1))
    assert inside.status == "complete"
    through = planner.plan(local, (0.1, 0.1, 0.1), (15.0, 0.1, 0.1))
    assert through.status != "complete"
    assert np.linalg.norm(through.path[:, :2], axis=1).max() < 10.0 - 0.8
    empty = voxnav.SubmapCollection()
    assert planner.plan(empty, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)).status == "outside_map"


def test_shipped_parameters_are_the_defaults():
    sections = yaml.safe_load(CONFIG.read_text())
    classes = dict(node=voxnav.PlanningNodeConfig, manager=voxnav.PlanningManagerConfig,
                   planner=voxnav.FlightSearchConfig, map=voxnav.NavigationMapConfig, fences=voxnav.FencesConfig,
                   home=voxnav.HomeConfig, heading=voxnav.HeadingConfig, work=voxnav.WorkTimeConfig,
                   time=voxnav.TimeConfig, others=voxnav.OtherUavsConfig)
    assert set(sections) == set(classes)
    for name, config_class in classes.items():
        assert config_class.from_dict(sections[name]).to_dict() == config_class().to_dict()
        assert set(sections[name]) == set(config_class().to_dict()), "the file lists every field"
