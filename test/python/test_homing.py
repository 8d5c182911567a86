# SPDX-License-Identifier: BSD-3-Clause
"""A known way home is kept, with its length and time, and goals beyond the battery's reserve are refused."""

import numpy as np
import pytest

import voxnav
from fake_flight import LIMITS
from test_planning_manager import WALL, reached, started, world
from voxnav.homing import (Battery, HomeKeeper, HomeState, HomeTrack, MapCorrections, Watch, beyond_reserve,
                           or_way_home, watch_reserve, way_in_O)
from voxnav.homing.reserve import Trip
from voxnav.planning_manager import Control, Reason

GOAL = (25.0, 0.0, 0.0)


def length_of(line):
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def distance_to_line(points, line):
    """Returns the distance (n,) of points from the polyline."""
    out = np.full(len(points), np.inf)
    for a, b in zip(line[:-1], line[1:]):
        t = np.clip((points - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-12), 0.0, 1.0)
        out = np.minimum(out, np.linalg.norm(points - a - t[:, None] * (b - a), axis=1))
    return out


def sampled(line, step_m=0.1):
    return np.vstack([np.linspace(a, b, 2 + int(np.linalg.norm(b - a) / step_m)) for a, b in zip(line[:-1], line[1:])])


# The way


def test_the_way_is_the_one_that_was_flown():
    track = HomeTrack((0.0, 0.0, 2.0))
    for x in np.arange(0.0, 10.0, 0.3):
        track.follow((x, 0.0, 2.0))
    for y in np.arange(0.0, 5.0, 0.3):
        track.follow((9.9, y, 2.0))
    way = track.way_W()
    assert way[0].tolist() == pytest.approx([9.9, 4.8, 2.0]) and way[-1].tolist() == [0.0, 0.0, 2.0]
    assert track.length_m() == pytest.approx(14.7, abs=1.0)


def test_loops_are_left_out_where_the_map_shows_free_space():
    track = HomeTrack((0.0, 0.0, 2.0))
    circle = [(10.0 * np.sin(a), 10.0 - 10.0 * np.cos(a), 2.0) for a in np.arange(0.0, 2.0 * np.pi - 0.2, 0.02)]
    for place in circle:
        track.follow(place)
    assert track.length_m() > 55.0
    track.shorten(lambda line: False)
    assert track.length_m() > 55.0
    track.shorten(lambda line: True)
    assert track.length_m() == pytest.approx(np.linalg.norm(np.subtract(circle[-1], (0.0, 0.0, 2.0))))


@pytest.mark.parametrize("seed", range(20))
def test_every_line_of_the_way_was_flown_or_found_free(seed):
    rng = np.random.default_rng(seed)
    posts = rng.uniform(-20.0, 20.0, (40, 2))
    free_lines, asked = [], []

    def is_free(line):
        asked.append(line)
        near = min(distance_to_line(np.column_stack([posts, np.zeros(len(posts))]), line * (1.0, 1.0, 0.0)))
        if near > 1.0:
            free_lines.append(line)
        return near > 1.0

    place, heading = np.zeros(3), 0.0
    track, flown = HomeTrack(place), [place]
    for step in range(600):
        heading += rng.normal(0.05, 0.15)
        place = place + 0.3 * np.array([np.cos(heading), np.sin(heading), rng.normal(0.0, 0.1)])
        flown.append(place)
        track.follow(place)
        before = len(asked)
        if step % 5 == 0:
            track.shorten(is_free)
        assert len(asked) - before <= 4
    way = track.way_W()
    assert np.allclose(way[0], place) and np.allclose(way[-1], 0.0)
    places = sampled(way)
    room = distance_to_line(places, np.array(flown))
    for line in free_lines:
        room = np.minimum(room, distance_to_line(places, line))
    assert room.max() < 1.0
    assert length_of(way) < 0.9 * length_of(np.array(flown))


def test_after_a_jump_the_way_is_not_known_but_the_start_is():
    track = HomeTrack((0.0, 0.0, 2.0))
    track.follow((1.0, 0.0, 2.0))
    track.follow((9.0, 0.0, 2.0))
    assert track.way_W() is None and track.length_m() is None and track.start_W.tolist() == [0.0, 0.0, 2.0]
    track.follow((9.5, 0.0, 2.0))
    track.shorten(lambda line: True)
    assert track.way_W() is None


def test_the_way_is_bounded():
    track = HomeTrack((0.0, 0.0, 2.0), max_points=50)
    for x in range(49):
        track.follow((float(x), 0.0, 2.0))
        assert track.way_W() is not None
    for x in range(49, 60):
        track.follow((float(x), 0.0, 2.0))
    assert track.way_W() is None


def test_a_vehicle_that_comes_back_to_its_way_goes_on_from_there():
    track = HomeTrack((0.0, 0.0, 2.0))
    for x in np.arange(0.0, 20.0, 0.3):
        track.follow((x, 0.0, 2.0))
    for x in np.arange(20.0, 7.0, -0.3):
        track.follow((x, 0.2, 2.0))
        assert track.length_m() < x + 2.5, "the way back is not added to the way"
    assert track.length_m() == pytest.approx(7.1, abs=0.5)


# The way follows the map


def shifted(x=0.0, y=0.0, yaw=0.0):
    out = np.eye(4)
    out[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    out[:2, 3] = (x, y)
    return out


def test_the_way_moves_with_the_submaps_in_which_it_was_flown():
    """Three submaps are flown through, and the last solution moves the first by 1 m and the second by 2 m along y."""
    track, corrections = HomeTrack((0.0, 0.0, 2.0)), MapCorrections()
    poses = {}
    for number in range(3):
        for x in np.arange(10.0 * number, 10.0 * number + 10.0, 0.5):
            track.follow((x, 0.0, 2.0))
        poses[number] = shifted(10.0 * number)
        track.correct(corrections.take(poses, np.eye(4), "odom"))
    assert np.abs(track.way_W()[:, 1]).max() == 0.0
    track.correct(corrections.take({0: shifted(0.0, 1.0), 1: shifted(10.0, 2.0), 2: shifted(20.0)}, np.eye(4), "odom"))
    way = track.way_W()
    assert track.start_W.tolist() == pytest.approx([0.0, 1.0, 2.0]) and np.allclose(way[-1], track.start_W)
    assert np.allclose(way[way[:, 0] < 9.4][:, 1], 1.0) and np.allclose(way[way[:, 0] > 20.6][:, 1], 0.0)
    assert np.allclose(way[(way[:, 0] > 10.6) & (way[:, 0] < 19.4)][:, 1], 2.0)


def test_what_is_in_no_submap_yet_moves_with_the_vehicle():
    track, corrections = HomeTrack((0.0, 0.0, 2.0)), MapCorrections()
    corrections.take({0: shifted()}, np.eye(4), "odom")
    for x in np.arange(0.0, 10.0, 0.5):
        track.follow((x, 0.0, 2.0))
    turn = shifted(0.0, 3.0, 0.3)
    track.correct(corrections.take({0: shifted()}, turn, "odom"))
    expected = turn[:3, :3] @ (9.5, 0.0, 2.0) + turn[:3, 3]
    assert np.allclose(track.way_W()[0], expected) and np.allclose(track.start_W, (0.0, 3.0, 2.0))
    track.follow(turn[:3, :3] @ (10.0, 0.0, 2.0) + turn[:3, 3])
    assert track.way_W() is not None, "a correction is no jump of the vehicle"
    track.correct(corrections.take({0: shifted()}, np.eye(4), "other odom"))
    assert np.allclose(track.start_W, (0.0, 3.0, 2.0)), "a switch of the estimator moves nothing in the map"


@pytest.mark.parametrize("seed", range(10))
def test_corrections_are_those_of_the_graph(seed):
    """Places are flown in O with drift; after each solution they are where the submaps have put them."""
    rng = np.random.default_rng(seed)
    track, corrections = HomeTrack(np.zeros(3), spacing_m=0.1, max_points=1000), MapCorrections()
    T_O_S, T_W_S, T_W_O, flown = {}, {}, np.eye(4), [(np.zeros(3), None)]
    for step in range(120):
        p_O = np.array([0.5 * step, 5.0 * np.sin(0.1 * step), 0.0])
        if step:
            flown.append((p_O, None))
        track.follow(T_W_O[:3, :3] @ p_O + T_W_O[:3, 3])
        if step % 15 == 14:
            number = len(T_O_S)
            T_O_S[number] = shifted(p_O[0], p_O[1], 0.1 * number)
            flown = [(p, number if submap is None else submap) for p, submap in flown]
            error = 0.0 if number == 0 else 1.0  # the first solution tells of nothing that has moved
            T_W_S = {each: shifted(*rng.normal(0.0, 0.5 * error, 2), rng.normal(0.0, 0.02 * error)) @ T_O_S[each]
                     for each in T_O_S}
            T_W_O = T_W_S[number] @ np.linalg.inv(T_O_S[number])
            track.correct(corrections.take(T_W_S, T_W_O, "odom"))
    expected = []
    for p_O, submap in flown:
        T = T_W_O if submap is None else T_W_S[submap] @ np.linalg.inv(T_O_S[submap])
        expected.append(T[:3, :3] @ p_O + T[:3, 3])
    way = track.way_W()[::-1]
    assert len(way) == len(expected) + 1 and np.allclose(way[:-1], expected, atol=1e-6)


# The keeper


def flown_round_a_wall():
    flight = started(world(WALL), GOAL, known_range_m=8.0)
    keeper = HomeKeeper(0.7, 0.2)
    return flight, keeper, lambda f: keeper.update(f.manager.inputs, f.map.view, f.now)


def test_at_all_times_there_is_a_way_home_through_free_space():
    flight, keeper, keep = flown_round_a_wall()
    for _ in range(1200):
        flight.step()
        keep(flight)
        state = keeper.state
        assert state.start_W is not None and state.way_m is not None and state.way_s is not None
        assert state.way_m >= np.linalg.norm(flight.position - state.start_W) - 1.0
        if reached(flight):
            break
    assert reached(flight)
    assert keeper.state.way_m <= length_of(np.array(flight.track)) + 1.0
    assert keeper.state.way_s == pytest.approx(voxnav.flight_time(keeper.way_W, LIMITS, 0.2))
    assert keeper.state.way_s > keeper.state.way_m / LIMITS[0]
    truth = voxnav.StateGrid.from_array(flight.truth, flight.origin, 0.4)
    assert voxnav.check_corridor(truth, keeper.way_W, 0.4).safe


def test_the_vehicle_returns_to_where_it_began():
    flight, keeper, keep = flown_round_a_wall()
    assert flight.fly(60.0, lambda f: keep(f) or reached(f))
    assert flight.manager.set_goal(keeper.state.start_W, None, flight.now) == ""
    assert flight.fly(60.0, lambda f: keep(f) or reached(f))
    assert np.linalg.norm(flight.position) < 1.5 and keeper.state.way_m < 2.0


DOOR = [((12.0, -10.0, -4.0), (13.0, -1.4, 4.0)), ((12.0, 1.4, -4.0), (13.0, 10.0, 4.0))]


class ReturningFlight:
    """A flight through a door, after which the search keeps farther from obstacles than the door is wide."""

    def __init__(self):
        self.flight = started(world(*DOOR), GOAL)
        self.keeper = HomeKeeper(0.7, 0.2)
        assert self.fly(), self.flight.manager.status.reason
        search = voxnav.FlightSearchConfig(unknown_policy="penalise", unknown_cost=2.0, safety_distance_m=2.2,
                                           clearance_distance_m=0.0, known_distance_m=0.0)
        self.flight.planner = voxnav.PathPlanner(search.planner_config())
        self.flight.field = voxnav.ClearanceField(search.field_config())

    def fly(self, until=reached):
        return self.flight.fly(60.0, lambda f: self.keeper.update(f.manager.inputs, f.map.view, f.now) or until(f))

    def let_the_way_stand_in(self):
        search, keeper, flight = voxnav.run_plan_job, self.keeper, self.flight

        def job(planner, field, config, view, start_O, goal_O, limits):
            searched = search(planner, field, config, view, start_O, goal_O, limits)
            return or_way_home(searched, way_in_O(keeper.way_W, goal_O, flight.T_W_O), lambda way_O:
                               voxnav.run_way_job(config, view, start_O, goal_O, limits, way_O))
        return job


def test_the_known_way_home_is_flown_where_the_search_finds_none(monkeypatch):
    back = ReturningFlight()
    monkeypatch.setattr(voxnav, "run_plan_job", back.let_the_way_stand_in())
    told = []
    assert back.flight.manager.set_goal(back.keeper.state.start_W, None, back.flight.now) == ""
    assert back.fly(lambda f: told.append(f.manager.status.reason) or reached(f)), back.flight.manager.status.reason
    assert np.linalg.norm(back.flight.position) < 0.8
    assert any("along the known way home: the search has found no other" in reason for reason in told)
    assert back.flight.clearance() > 0.7
    assert back.keeper.state.way_m < 2.0


def test_without_the_known_way_it_would_not_come_home():
    back = ReturningFlight()
    assert back.flight.manager.set_goal(back.keeper.state.start_W, None, back.flight.now) == ""
    assert not back.fly()
    assert back.flight.position[0] > 13.0


def test_a_known_way_that_is_closed_by_now_is_not_flown(monkeypatch):
    back = ReturningFlight()
    monkeypatch.setattr(voxnav, "run_plan_job", back.let_the_way_stand_in())
    back.flight.truth = world(*DOOR, ((12.0, -1.4, -4.0), (13.0, 1.4, 4.0)))
    back.flight.look()
    assert back.flight.manager.set_goal(back.keeper.state.start_W, None, back.flight.now) == ""
    assert not back.fly()
    assert back.flight.position[0] > 13.7, "the vehicle stays behind what closes the way"


def test_a_known_way_is_followed_from_its_nearest_place_on():
    free = voxnav.StateGrid.from_array(world(), (-4.0, -10.0, -4.0), 0.4)
    flight = started(world(), GOAL)
    flight.map.apply_local(99, 0.4, **free.snapshot())
    way = np.array([[20.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 5.0, 0.0], [0.0, 5.0, 0.0]])
    outcome = voxnav.run_way_job(flight.config, flight.map.view(), (12.0, 0.5, 0.0), (0.0, 5.0, 0.0), LIMITS, way)
    assert outcome.is_known_way and outcome.is_to_goal and outcome.status == voxnav.PlanStatus.COMPLETE
    np.testing.assert_allclose(outcome.plan.path, [[12.0, 0.5, 0.0], [12.0, 0.0, 0.0], [10.0, 0.0, 0.0],
                                                   [10.0, 5.0, 0.0], [0.0, 5.0, 0.0]])
    with pytest.raises(ValueError):
        voxnav.run_way_job(flight.config, flight.map.view(), (12.0, 0.5, 0.0), (0.0, 5.0, 0.0), LIMITS,
                           np.zeros((0, 3)))


def test_a_closed_map_takes_the_start_with_it_until_the_next_flight():
    flight, keeper, keep = flown_round_a_wall()
    assert flight.fly(5.0, lambda f: keep(f) or f.position[0] > 3.0)
    keeper.lose_map("the estimators are not related")
    flight.fly(1.0, lambda f: keep(f))
    assert keeper.state.start_W is None and keeper.way_W is None, "the place where the map was closed is no start"
    assert keeper.lost == "the estimators are not related"
    flight.is_flying = False
    flight.fly(4.0, lambda f: keep(f))
    flight.is_flying = True
    flight.fly(1.0, lambda f: keep(f))
    assert keeper.lost == "" and keeper.state.start_W is not None


def test_a_solution_of_the_graph_counts_when_its_map_correction_does():
    flight, keeper, keep = flown_round_a_wall()
    keeper.correct_map({0: shifted()}, np.eye(4), "odom")
    assert flight.fly(10.0, lambda f: keep(f) or f.position[0] > 6.0)
    start_W = keeper.state.start_W
    moved = shifted(0.0, 8.0)
    keeper.correct_map({0: shifted(), 1: shifted(5.0, 8.0)}, moved, "odom")
    flight.fly(0.5, lambda f: keep(f))
    assert np.allclose(keeper.state.start_W, start_W), "the inputs are still those of the solution before"
    flight.T_W_O = moved
    flight.fly(0.5, lambda f: keep(f))
    assert keeper.way_W is not None, "8 m of correction are no jump of the vehicle"
    assert np.linalg.norm(keeper.way_W[0] - (moved[:3, :3] @ flight.position + moved[:3, 3])) < 2.0


def test_a_new_flight_has_a_new_start():
    flight, keeper, keep = flown_round_a_wall()
    assert flight.fly(60.0, lambda f: keep(f) or reached(f))
    flight.is_flying = False
    flight.fly(1.0, lambda f: keep(f))
    assert keeper.state.start_W is not None, "a moment without control is no landing"
    flight.fly(4.0, lambda f: keep(f))
    assert keeper.state.start_W is None and keeper.way_W is None
    flight.is_flying = True
    flight.fly(1.0, lambda f: keep(f))
    assert np.linalg.norm(keeper.state.start_W - flight.position) < 0.5


def test_a_vehicle_that_does_not_fly_has_no_way_home():
    flight, keeper, keep = flown_round_a_wall()
    flight.is_flying = False
    flight.manager.set_control(flight.now, Control(False, False, False))
    flight.fly(1.0, lambda f: keep(f))
    assert keeper.state.start_W is None and keeper.state.way_m is None


# The reserve


CONFIG = voxnav.HomeConfig(full_flight_time_s=600.0, reserve_s=60.0, detour_ratio=1.0)
HOME = HomeState(np.array([0.0, 0.0, 2.0]), 100.0, 30.0)


def trip(goal, here=(0.0, 0.0, 2.0), home=HOME):
    return Trip(np.array(goal, dtype=float), np.array(here, dtype=float), home, LIMITS)


def test_goals_beyond_the_reserve_are_refused_with_the_figures():
    # 400 m at 4 m/s and 2 m/s^2 take 102 s, there as back.
    far = trip((400.0, 0.0, 2.0))
    assert far.times_s(1.0) == pytest.approx((102.0, 102.0))
    assert beyond_reserve(far, Battery(0.0, 0.45), CONFIG, 1.0) is None
    because = beyond_reserve(far, Battery(0.0, 0.43), CONFIG, 1.0)
    assert because.reason is Reason.GOAL_BEYOND_RESERVE
    assert because.sentence == ("goal needs 102 s there and 102 s back, and the battery holds 258 s, of which 60 s are "
                                "reserve")


def test_the_way_back_is_no_longer_than_the_known_one():
    # From the far end of the way, a goal beside it: back along the way there, and the known way.
    beside = trip((400.0, 4.0, 2.0), here=(400.0, 0.0, 2.0), home=HomeState(np.array([0.0, 0.0, 2.0]), 380.0, 100.0))
    there_s, back_s = beside.times_s(2.0)
    assert there_s == pytest.approx(4.0) and back_s == pytest.approx(388.0 / 4.0 + 2.0)


@pytest.mark.parametrize("battery, words", [
    (None, "the charge of the battery is not known"), (Battery(0.0, 1.0), "the charge of the battery is not known"),
    (Battery(95.0, None), "the charge of the battery is not measured")])
def test_a_battery_that_tells_nothing_allows_no_goal(battery, words):
    assert beyond_reserve(trip((5.0, 0.0, 2.0)), battery, CONFIG, 100.0).sentence == words


def test_nothing_is_refused_by_default_and_the_way_home_never():
    assert beyond_reserve(trip((9000.0, 0.0, 2.0)), None, voxnav.HomeConfig(), 0.0) is None
    assert beyond_reserve(trip((0.5, 0.0, 2.0), here=(900.0, 0.0, 2.0)), Battery(0.0, 0.01), CONFIG, 0.0) is None


def test_in_flight_a_battery_that_holds_for_the_way_home_and_the_reserve_no_longer_is_told():
    home = HomeState(np.zeros(3), 200.0, 55.0)
    holds = watch_reserve(home, Battery(0.0, 0.2), CONFIG, 1.0)  # 120 s, of which 115 s are needed
    assert holds.watch is Watch.HOLDS and holds.sentence == ""
    reached_reserve = watch_reserve(home, Battery(0.0, 0.19), CONFIG, 1.0)
    assert reached_reserve.watch is Watch.REACHED and reached_reserve.sentence == (
        "the way home needs 55 s, and the battery holds 114 s, of which 60 s are reserve: return now")
    for silent in (watch_reserve(home, Battery(0.0, 0.01), voxnav.HomeConfig(), 1.0),
                   watch_reserve(HomeState(), None, CONFIG, 1.0)):
        assert silent.watch is Watch.SILENT and silent.sentence == "", "nothing is configured, or nothing flies"


NO_WAY, NOT_KNOWN = "the way home is not known", "the charge of the battery is not known"


@pytest.mark.parametrize("way_s, battery, now_s, words", [
    (None, Battery(0.0, 0.5), 1.0, NO_WAY), (55.0, None, 1.0, NOT_KNOWN), (55.0, Battery(0.0, 0.5), 1000.0, NOT_KNOWN),
    (55.0, Battery(0.0, None), 1.0, "the charge of the battery is not measured"),
    (None, None, 1.0, NO_WAY + ", and " + NOT_KNOWN)])
def test_it_is_told_which_of_the_way_home_and_the_battery_is_not_known(way_s, battery, now_s, words):
    watched = watch_reserve(HomeState(np.zeros(3), 200.0, way_s), battery, CONFIG, now_s)
    assert watched.watch is Watch.UNKNOWN
    assert watched.sentence == "nobody tells when to return: " + words


def test_the_manager_tells_why_a_goal_is_beyond_the_reserve():
    flight = started(world(), GOAL)
    flight.manager.judge = lambda goal_W: beyond_reserve(trip(goal_W), Battery(flight.now, 0.1), CONFIG, flight.now)
    assert "and the battery holds 60 s" in flight.manager.set_goal((24.0, 0.0, 0.0), None, flight.now)
    assert flight.manager.status.refusal.reason is Reason.GOAL_BEYOND_RESERVE
