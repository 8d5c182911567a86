# SPDX-License-Identifier: BSD-3-Clause
"""Other UAVs: what they announce is read and kept, and two planners cross without coming near to each other."""

import numpy as np
import pytest

import voxnav
from fake_flight import RESOLUTION, FakeFlight
from test_planning_manager import reached, world
from voxnav.other_uavs import (Announced, AnnouncementError, Keeper, KeptTransform, OriginUnknown, begin_of,
                               has_right_of_way)
from voxnav.planning_manager import Reason

UTM = np.array([446363.0, 5468016.5, 0.0])
T_O_UTM = np.eye(4)
T_O_UTM[:3, 3] = -UTM
STEPS = 0.2 * np.arange(40)[:, None]


def announced(name="uav2", priority=2, begin_s=10.0, velocity=(1.0, 0.0, 0.0), start=(0.0, 0.0, 2.0)):
    places = np.asarray(start) + STEPS * np.asarray(velocity) + UTM
    return Announced.of(name, priority, begin_s, begin_s, places.astype(np.float32))


def keeper(own="uav1", **config):
    return Keeper(voxnav.OtherUavsConfig(**config), own, ["uav1", "uav2", "uav3"])


def test_of_any_two_exactly_one_gives_way():
    names = ["uav1", "uav2", "uav10", "robot", "rover_a"]
    priority = {"uav1": 1, "uav2": 2, "uav10": 10, "robot": 0, "rover_a": 0}
    for a in names:
        for b in names:
            if a != b and (a.startswith("uav") == b.startswith("uav")):
                assert has_right_of_way(a, b, priority[b]) != has_right_of_way(b, a, priority[a]), (a, b)
    assert has_right_of_way("uav1", "uav2", 2) and has_right_of_way("uav2", "uav10", 10)


def test_single_precision_of_utm_is_a_part_of_the_error():
    here = announced()
    assert 0.25 < here.rounding_m < 0.27
    kept = keeper(body_radius_m=0.5, position_error_m=1.0)
    kept.take(here)
    other = kept.others(10.0, T_O_UTM)[0]
    assert other.radius_m == pytest.approx(1.5 + here.rounding_m)
    assert np.abs(other.places_O - (STEPS * (1, 0, 0) + (0, 0, 2))).max() <= 0.26


def test_bad_announcements_are_refused():
    for places in (np.zeros((0, 3)), np.zeros((2000, 3)), np.full((40, 3), np.nan), np.full((40, 3), 1e30)):
        with pytest.raises(AnnouncementError):
            Announced.of("uav2", 2, 0.0, 0.0, places)


def test_stamps_of_another_clock_do_not_count():
    assert begin_of(10.0, 10.2, 0.5) == (10.0, True)
    assert begin_of(9.0, 10.2, 0.5) == (10.2, False)
    assert begin_of(11.0, 10.2, 0.5) == (10.2, False)


def test_a_silent_one_is_kept_clear_of_ever_farther_until_it_is_forgotten():
    kept = keeper(silent_after_s=1.5, silent_growth_mps=1.0, max_growth_m=5.0, forget_after_s=30.0, near_horizon_s=2.0,
                  horizon_s=8.0)
    kept.take(announced(velocity=(2.0, 0.0, 0.0)))
    assert kept.never_heard == ["uav3"] and kept.names == ("uav2", "uav3")
    now = kept.others(11.0, T_O_UTM)[0]
    assert now.horizon_s == 2.0 and now.body_radius_m == now.radius_m and kept.silent(11.0) == []
    late = kept.others(13.5, T_O_UTM)[0]
    assert kept.silent(13.5) == ["uav2"]
    assert late.horizon_s == 8.0, "who is silent is not trusted to give way"
    assert late.body_radius_m == 0.0, "it is not known any more where its body is: it is mapped like anything else"
    assert late.radius_m == pytest.approx(now.radius_m + 2.0)
    assert kept.others(29.0, T_O_UTM)[0].radius_m == pytest.approx(now.radius_m + 5.0)
    assert kept.forget(39.0) == [] and kept.forget(41.0) == ["uav2"]
    assert kept.others(41.0, T_O_UTM) == [] and kept.forgotten == ["uav2"]
    kept.take(announced(begin_s=42.0))
    assert kept.forgotten == [] and len(kept.others(42.0, T_O_UTM)) == 1


def test_who_rests_does_not_give_way():
    kept = keeper(near_horizon_s=2.0, horizon_s=8.0)
    kept.take(announced(velocity=(0.0, 0.0, 0.0)))
    kept.take(announced("uav3", 3))
    rests, moves = kept.others(10.1, T_O_UTM)
    assert (rests.horizon_s, moves.horizon_s) == (8.0, 2.0) and rests.gives_way and moves.gives_way


# The transform from UTM


def test_a_transform_that_tf_lost_holds_for_a_while():
    kept = KeptTransform(10.0)
    with pytest.raises(OriginUnknown, match="no transform yet"):
        kept.at(5.0)
    kept.take(T_O_UTM, 5.0)
    assert kept.at(5.0) is T_O_UTM and kept.at(14.9) is T_O_UTM
    with pytest.raises(OriginUnknown, match="nobody has told its transform for more than 10.0 s"):
        kept.at(15.1)
    kept.take(T_O_UTM, 15.0)
    assert kept.at(15.1) is T_O_UTM
    with pytest.raises(OriginUnknown):
        kept.at(1.0)  # the clock jumped back: the stamp tells nothing


def test_a_static_transform_holds_for_ever():
    kept = KeptTransform(10.0)
    kept.take(T_O_UTM, None)
    assert kept.at(1e6) is T_O_UTM


def test_after_a_jump_of_the_odometry_only_a_newer_transform_holds():
    kept = KeptTransform(10.0)
    kept.take(T_O_UTM, 5.0)
    kept.forget(jump_s=6.0)
    kept.take(T_O_UTM, 5.9)
    with pytest.raises(OriginUnknown, match="no transform since the odometry jumped"):
        kept.at(6.0)
    moved = T_O_UTM + 1.0
    kept.take(moved, 6.0)
    assert kept.at(6.0) is moved


# Two planners

SIZE_ORIGIN = (-4.0, -10.0, -4.0)


class Crossing:
    """Two FakeFlights, each of which hears the predictions of the other twice a second."""

    def __init__(self, truth, starts, goals, error=(0.0, 0.0, 0.0), is_heard=(True, True)):
        self.config = voxnav.OtherUavsConfig(position_error_m=1.0)
        self.flights = [FakeFlight(truth, SIZE_ORIGIN, start) for start in starts]
        self.keepers = [Keeper(self.config, "uav%d" % (i + 1), ["uav1", "uav2"]) for i in range(2)]
        self.error, self.is_heard, self.least_m = np.asarray(error), is_heard, np.inf
        for flight, goal in zip(self.flights, goals):
            flight.look()
            flight.tell()
            assert goal is None or flight.manager.set_goal(goal, None, flight.now) == ""

    def announce(self):
        for i, flight in enumerate(self.flights):
            places = np.array([flight.position_at(flight.now + 0.01 + t) for t in STEPS[:, 0]]) + UTM
            if self.is_heard[i]:
                self.keepers[1 - i].take(Announced.of("uav%d" % (i + 1), i + 1, flight.now, flight.now, places))

    def tell(self):
        config = self.config
        for i, flight in enumerate(self.flights):
            T = T_O_UTM.copy()
            T[:3, 3] += self.error * (1 if i == 0 else -1)
            flight.map.set_others([voxnav.OtherUav(
                name=o.name, stamp_s=o.begin_s, step_s=config.step_s, places=o.places_O, radius_m=o.radius_m,
                growth_mps=config.growth_mps, late_growth_mps=config.late_growth_mps,
                max_growth_m=config.max_growth_m, horizon_s=o.horizon_s, seen_s=flight.now)
                for o in self.keepers[i].others(flight.now, T)])
            flight.map.set_sightings(flight.now, RESOLUTION, np.zeros((0, 3), np.int32), np.zeros(0, np.int32),
                                     np.zeros((0, 12)))

    def fly(self, seconds):
        for step in range(int(20 * seconds)):
            if step % 10 == 0:
                self.announce()
            if step % 2 == 0:
                self.tell()
            for flight in self.flights:
                flight.step()
            self.least_m = min(self.least_m, np.linalg.norm(self.flights[0].position - self.flights[1].position))
            if all(reached(flight) for flight in self.flights):
                return True
        return False

    def reasons(self):
        return [flight.manager.status.reason for flight in self.flights]


@pytest.mark.parametrize("shift_m", [0.0, 0.4, -1.0, 2.0])
def test_two_that_come_towards_each_other_pass(shift_m):
    ends = [(0.0, 0.0, 0.0), (36.0, shift_m, 0.0)]
    crossing = Crossing(world(), ends, ends[::-1])
    assert crossing.fly(90.0), crossing.reasons()
    assert crossing.least_m > 2.0
    assert crossing.flights[0].count("hover") == 0, "who has the right of way flies on"


def test_two_pass_although_their_positions_err():
    ends = [(0.0, 0.0, 0.0), (36.0, 0.0, 0.0)]
    crossing = Crossing(world(), ends, ends[::-1], error=(0.5, 0.8, 0.2))
    assert crossing.fly(90.0), crossing.reasons()
    assert crossing.least_m > 1.2


def test_two_pass_through_a_gap_one_after_the_other():
    walls = [((16.0, -11.0, -4.0), (17.0, -2.0, 4.0)), ((16.0, 2.0, -4.0), (17.0, 11.0, 4.0))]
    ends = [(0.0, 0.0, 0.0), (34.0, 0.0, 0.0)]
    crossing = Crossing(world(*walls), ends, ends[::-1])
    assert crossing.fly(180.0), crossing.reasons()
    assert crossing.least_m > 1.5


@pytest.mark.parametrize("mover", [0, 1])
def test_one_at_rest_is_flown_around(mover):
    starts, goals = [(0.0, 0.0, 0.0), (18.0, 0.0, 0.0)], [(36.0, 0.0, 0.0), None]
    if mover == 1:
        starts, goals = starts[::-1], goals[::-1]
    crossing = Crossing(world(), starts, goals)
    for _ in range(90):
        crossing.fly(1.0)
        if reached(crossing.flights[mover]):
            break
    assert reached(crossing.flights[mover]), crossing.reasons()
    assert crossing.least_m > 2.0


def test_without_news_they_would_collide():
    ends = [(0.0, 0.0, 0.0), (36.0, 0.0, 0.0)]
    crossing = Crossing(world(), ends, ends[::-1], is_heard=(False, False))
    crossing.fly(60.0)
    assert crossing.least_m < 0.7


def test_where_others_are_must_be_known():
    flight = FakeFlight(world(), SIZE_ORIGIN, (0.0, 0.0, 0.0))
    flight.look()
    flight.tell()
    flight.manager.set_others_problem("where other UAVs are is not known: no transform")
    assert flight.manager.set_goal((20.0, 0.0, 0.0), None, flight.now) == ""
    flight.fly(3.0)
    status = flight.manager.status
    assert np.linalg.norm(flight.position) < 0.1 and status.because.reason is Reason.OTHERS_UNPLACED
    flight.manager.set_others_problem("")
    assert flight.fly(60.0, reached)


def test_others_that_are_none_are_refused():
    good = dict(name="uav2", stamp_s=1.0, step_s=0.2, places=np.zeros((2, 3)), radius_m=1.0, growth_mps=0.0,
                late_growth_mps=0.0, max_growth_m=0.0, horizon_s=5.0, seen_s=1.0)
    view = voxnav.NavigationMap()
    view.set_others([voxnav.OtherUav(**good)])
    for bad in (dict(places=np.zeros((0, 3))), dict(radius_m=-1.0), dict(step_s=0.0),
                dict(places=np.full((2, 3), np.nan)), dict(horizon_s=np.inf)):
        with pytest.raises(ValueError):
            view.set_others([voxnav.OtherUav(**dict(good, **bad))])
