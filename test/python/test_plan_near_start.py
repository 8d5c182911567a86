# SPDX-License-Identifier: BSD-3-Clause
"""Plans leave the start beside the cones above and below the vehicle, which the LiDAR cannot see."""

import itertools

import numpy as np
import pytest

import voxnav

RESOLUTION = 0.4
LIMITS = [4.0, 2.0, 2.0, 1.0, 2.0, 1.0]


def seen_from(vehicle, elevation_deg=45.0, range_m=12.0):
    """Returns the grid that is known after a scan in free space: all voxels that a beam touches are free.

    Beams cover the elevations from -elevation_deg to elevation_deg.
    """
    n = int(2 * range_m / RESOLUTION)
    low = np.floor((np.asarray(vehicle) - range_m) / RESOLUTION) * RESOLUTION
    centers = [low[k] + (np.arange(n) + 0.5) * RESOLUTION - vehicle[k] for k in range(3)]
    farthest = np.hypot(np.abs(centers[0])[:, None] + 0.2, np.abs(centers[1])[None, :] + 0.2)
    lowest = np.maximum(np.abs(centers[2]) - 0.2, 0.0)
    is_seen = lowest[None, None, :] <= np.tan(np.radians(elevation_deg)) * farthest[:, :, None]
    return voxnav.StateGrid.from_array(is_seen.astype(np.int8), low, RESOLUTION)


def plan(vehicle, goal, **search):
    nav = voxnav.NavigationMap(voxnav.NavigationMapConfig(min_altitude_m=-20.0))
    assert nav.apply_local(1, RESOLUTION, **seen_from(vehicle).snapshot()) == voxnav.Applied.APPLIED
    nav.set_vehicle(vehicle)
    nav.set_T_W_O(np.eye(4))
    view = nav.view()
    config = voxnav.FlightSearchConfig(**search)
    planner, field = voxnav.PathPlanner(config.planner_config()), voxnav.ClearanceField(config.field_config())
    field.update(view)
    return view, voxnav.run_plan_job(planner, field, voxnav.PlanningManagerConfig(), view, vehicle, goal, LIMITS)


OFFSETS = list(itertools.product((0.0, 0.13, 0.31), (0.05, 0.25), (0.0, 0.2, 0.35)))


@pytest.mark.parametrize("goal", [(0.0, 0.0, 25.0), (9.0, 3.0, 20.0), (30.0, 0.0, 30.0), (3.0, 0.0, -18.0)])
def test_steep_goals_are_approached_beside_the_blind_cones(goal):
    for vehicle in OFFSETS:
        view, outcome = plan(np.array(vehicle), np.array(goal))
        assert outcome.problem == "", (vehicle, outcome.problem)
        assert np.linalg.norm(np.diff(outcome.waypoints_O, axis=0), axis=1).sum() >= 1.0
        assert voxnav.check_corridor(view, outcome.waypoints_O, 0.7).safe


def test_without_known_distance_a_steep_goal_leads_into_the_unknown_cone():
    outcomes = [plan(np.array(vehicle), np.array((0.0, 0.0, 25.0)), known_distance_m=0.0)[1] for vehicle in OFFSETS]
    assert any("unknown" in o.problem for o in outcomes)


def beside_a_wall(distance_m, thickness_m=0.8):
    """Returns the plan of a vehicle this near to a wall of voxels, in space that is known all around."""
    truth = np.ones((60, 60, 30), dtype=np.int8)
    first = 30
    truth[first:first + int(round(thickness_m / RESOLUTION))] = 2
    nav = voxnav.NavigationMap(voxnav.NavigationMapConfig(min_altitude_m=-20.0))
    grid = voxnav.StateGrid.from_array(truth, (-12.0, -12.0, -6.0), RESOLUTION)  # the wall begins at x = 0
    assert nav.apply_local(1, RESOLUTION, **grid.snapshot()) == voxnav.Applied.APPLIED
    vehicle, goal = np.array((-distance_m, 0.1, 0.1)), np.array((-9.0, 5.0, 0.1))
    nav.set_vehicle(vehicle)
    nav.set_T_W_O(np.eye(4))
    view, config = nav.view(), voxnav.FlightSearchConfig()
    planner, field = voxnav.PathPlanner(config.planner_config()), voxnav.ClearanceField(config.field_config())
    field.update(view)
    return view, voxnav.run_plan_job(planner, field, voxnav.PlanningManagerConfig(), view, vehicle, goal, LIMITS)


@pytest.mark.parametrize("distance_m", [0.1, 0.25, 0.4, 0.49])
def test_a_place_with_less_room_than_the_vehicle_is_left_without_going_nearer(distance_m):
    view, outcome = beside_a_wall(distance_m)
    assert outcome.problem == "" and len(outcome.waypoints_O) >= 2
    assert outcome.corridor_radius_m == pytest.approx(distance_m, abs=2e-3)
    assert voxnav.check_corridor(view, outcome.waypoints_O, outcome.corridor_radius_m).safe
    end = outcome.waypoints_O[-1]
    assert -end[0] >= voxnav.PlanningManagerConfig().min_corridor_radius_m - 1e-3, "the vehicle's own radius fits there"
    assert not outcome.is_to_goal and outcome.left_m > 5.0, "the rest is planned from there"


def test_with_room_for_the_vehicle_the_plan_is_the_usual_one():
    outcome = beside_a_wall(0.6)[1]
    assert outcome.problem == "" and outcome.corridor_radius_m == 0.5


def test_a_vehicle_inside_an_occupied_voxel_has_no_way_out():
    outcome = beside_a_wall(-0.2)[1]
    assert len(outcome.waypoints_O) == 0 and "start" in outcome.problem
