# SPDX-License-Identifier: BSD-3-Clause
"""A known way home is kept, with its length and time, and goals beyond the battery's reserve are refused."""

import numpy as np
import pytest

import voxnav
from fake_flight import LIMITS
from test_planning_manager import WALL, reached, started, world
from voxnav.homing import Battery, HomeKeeper, HomeState, HomeTrack, beyond_reserve, reserve_warning
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
    assert reserve_warning(home, Battery(0.0, 0.2), CONFIG, 1.0) == ""  # 120 s, of which 115 s are needed
    assert reserve_warning(home, Battery(0.0, 0.19), CONFIG, 1.0) == (
        "the way home needs 55 s, and the battery holds 114 s, of which 60 s are reserve: return now")
    for state, battery, now_s in ((HomeState(np.zeros(3)), Battery(0.0, 0.01), 1.0), (home, None, 1.0),
                                  (home, Battery(0.0, None), 1.0), (home, Battery(0.0, 0.01), 1000.0)):
        assert reserve_warning(state, battery, CONFIG, now_s) == ""
    assert reserve_warning(home, Battery(0.0, 0.01), voxnav.HomeConfig(), 1.0) == ""


def test_the_manager_tells_why_a_goal_is_beyond_the_reserve():
    flight = started(world(), GOAL)
    flight.manager.judge = lambda goal_W: beyond_reserve(trip(goal_W), Battery(flight.now, 0.1), CONFIG, flight.now)
    assert "and the battery holds 60 s" in flight.manager.set_goal((24.0, 0.0, 0.0), None, flight.now)
    assert flight.manager.status.refusal.reason is Reason.GOAL_BEYOND_RESERVE
