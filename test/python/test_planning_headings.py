# SPDX-License-Identifier: BSD-3-Clause
"""Headings of paths follow the direction of flight, stay as they are, or are free, as the parameters say."""

import types

import numpy as np
import pytest

import voxnav

pytest.importorskip("rospy", reason="rospy is not installed")
from voxnav.nodes.planning_headings import Headings, directions_rad, with_turns  # noqa: E402

CORNER = [[0, 0, 2], [6, 0, 2], [6, 6, 2], [6, 6, 8]]


def applied(waypoints, goal_rad, present_rad=0.3, **config):
    path = types.SimpleNamespace(use_heading=None, relax_heading=None)
    points, headings = Headings(voxnav.HeadingConfig(**config)).apply(path, waypoints, goal_rad, present_rad)
    assert len(points) == len(headings)
    return path, points, headings


def test_a_goal_alone_is_looked_at_only_where_it_has_a_heading():
    path, points, _ = applied(CORNER, None)
    assert (path.use_heading, path.relax_heading) == (False, True)
    path, points, headings = applied(CORNER, 1.2)
    assert (path.use_heading, path.relax_heading) == (True, False)
    assert headings == [1.2] * 4
    np.testing.assert_array_equal(points, CORNER)


def test_a_fixed_heading_is_never_changed():
    for goal in (None, 1.2):
        path, points, _ = applied(CORNER, goal, mode="fixed")
        assert (path.use_heading, path.relax_heading) == (False, True)
        np.testing.assert_array_equal(points, CORNER)


def test_the_direction_of_flight_is_that_of_the_path_ahead():
    path, points, headings = applied(CORNER, None, mode="flight_direction")
    assert (path.use_heading, path.relax_heading) == (True, True)
    by_point = {tuple(p): h for p, h in zip(points.tolist(), headings)}
    assert by_point[(0, 0, 2)] == pytest.approx(0.0)
    assert by_point[(1, 0, 2)] == pytest.approx(0.0)
    assert by_point[(6, 0, 2)] == pytest.approx(np.pi / 2)
    assert by_point[(6, 6, 2)] == pytest.approx(np.pi / 2)  # upwards the last direction holds
    assert by_point[(6, 6, 8)] == pytest.approx(np.pi / 2)


def test_an_offset_turns_the_vehicle_and_not_its_goal():
    _, _, headings = applied(CORNER, 2.5, mode="flight_direction", offset_rad=0.5)
    assert headings[0] == pytest.approx(0.5)
    assert headings[-1] == 2.5


def test_a_vertical_path_keeps_the_present_heading():
    for offset in (0.0, 0.7):
        _, _, headings = applied([[0, 0, 2], [0, 0, 9]], None, 0.3, mode="flight_direction", offset_rad=offset)
        assert headings == pytest.approx([0.3] * len(headings))


def test_turns_begin_and_end_near_the_corners_and_bend_nothing():
    points = with_turns(CORNER, 1.0, True)
    np.testing.assert_allclose(points[1], [1, 0, 2])
    np.testing.assert_allclose(points[-2], [6, 6, 7])
    for point in points:
        assert min(np.linalg.norm(np.cross(point - np.array(a), np.array(b) - np.array(a))) / 6.0
                   for a, b in zip(CORNER[:-1], CORNER[1:])) < 1e-9
    short = [[0, 0, 2], [1.5, 0, 2]]
    np.testing.assert_array_equal(with_turns(short, 1.0, True), short)


def test_without_a_known_heading_the_flight_does_not_turn():
    path, points, _ = applied(CORNER, None, None, mode="flight_direction")
    assert (path.use_heading, path.relax_heading) == (False, True)


def test_small_bends_cause_no_turns():
    points = [[0, 0, 2], [2, 0, 2], [2.05, 0.05, 2], [8, 0.1, 2]]
    assert np.abs(directions_rad(points, 1.0, 0.0)).max() < 0.1
