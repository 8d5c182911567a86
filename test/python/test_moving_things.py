# SPDX-License-Identifier: BSD-3-Clause
"""A flight keeps clear of what moves: of a person who crosses its way, and of another UAV that comes towards it."""

import numpy as np
import pytest
from fake_flight import LIMITS, RESOLUTION, FakeFlight

import voxnav

HALF_M = np.array([0.3, 0.3, 0.9])
FREE, OCCUPIED = 1, 2


class CrossedFlight(FakeFlight):
    """A flight in free space in which something moves, of which every sweep tells place and velocity."""

    def __init__(self, place, velocity, **config):
        truth = np.ones((100, 60, 20), dtype=np.int8)
        super().__init__(truth, (-10.0, -12.0, -4.0), (0.0, 0.0, 0.0), known_range_m=40.0, **config)
        self.place, self.velocity_of_thing = np.array(place, dtype=float), np.array(velocity, dtype=float)
        self.begin = self.now
        self.nearest_m = np.inf
        self.tells = True

    def thing(self):
        return self.place + (self.now - self.begin) * self.velocity_of_thing

    def tell(self):
        offset = self.position - self.thing()
        across = max(0.0, np.hypot(offset[0], offset[1]) - HALF_M[0])
        self.nearest_m = min(self.nearest_m, np.hypot(across, max(0.0, abs(offset[2]) - HALF_M[2])))
        row = np.concatenate([[1.0], self.thing(), self.velocity_of_thing, HALF_M, [0.1, 0.1]])
        things = row.reshape(1, 12) if self.tells else np.zeros((0, 12))
        self.map.set_sightings(self.now, RESOLUTION, np.zeros((0, 3), dtype=np.int32), np.zeros(0, dtype=np.int32),
                               things)
        super().tell()


def flown(place, velocity, tells=True):
    flight = CrossedFlight(place, velocity)
    flight.tells = tells
    flight.look()
    flight.tell()
    assert flight.manager.set_goal((18.0, 0.0, 0.0), None, flight.now) == ""
    flight.is_there = flight.fly(60.0, lambda f: f.manager.status["is_goal_reached"])
    return flight


@pytest.mark.parametrize("place,velocity", [((8.0, -8.0, 0.0), (0.0, 1.4, 0.0)),  # a person crosses
                                            ((9.9, 6.5, 0.0), (-0.5, -1.3, 0.0)),
                                            ((22.0, 0.3, 0.0), (-2.0, 0.0, 0.0))])  # a UAV comes towards it
def test_a_flight_keeps_clear_of_what_moves_and_reaches_its_goal(place, velocity):
    unwarned, warned = flown(place, velocity, tells=False), flown(place, velocity)
    print("nearest %.2f m, %.2f m without prediction; log %s" % (warned.nearest_m, unwarned.nearest_m, warned.log))
    assert unwarned.nearest_m < 0.3, "the test shows nothing"
    assert warned.is_there
    assert warned.nearest_m > 0.6


def test_what_moves_away_is_no_reason_to_brake():
    flight = flown((12.0, 3.0, 0.0), (0.5, 1.5, 0.0))
    assert flight.is_there and flight.count("hover") == 0
    assert not any("moves is met" in sentence for _, sentence in flight.log)


def free_map(hits, returns):
    """Returns a view of free space in which a sweep hit some voxels, with the vehicle at the origin."""
    nav = voxnav.NavigationMap(voxnav.NavigationMapConfig(min_altitude_m=-5.0, max_altitude_m=20.0))
    grid = voxnav.StateGrid.from_array(np.ones((80, 40, 20), dtype=np.int8), (-8.0, -8.0, -4.0), RESOLUTION)
    assert nav.apply_local(1, RESOLUTION, **grid.snapshot()) == voxnav.Applied.APPLIED
    nav.set_T_W_O(np.eye(4))
    nav.set_vehicle((0.0, 0.0, 0.0))
    voxels, returns = np.array(hits, dtype=np.int32).reshape(-1, 3), np.array(returns, dtype=np.int32)
    nav.set_sightings(10.0, RESOLUTION, voxels, returns, np.zeros((0, 12)))
    return nav.view()


def safe(view, speed_mps):
    config = voxnav.PlanningManagerConfig()
    line = np.zeros((60, 3))
    line[:, 0] = np.minimum(0.1 * speed_mps * np.arange(60), 9.0)
    return voxnav.safe_part(config, view, voxnav.Trajectory(line, 0.1), 0.0, 0.7, (speed_mps, 0.0, 0.0), LIMITS, 10.0)


def test_connected_hits_of_one_sweep_count_as_occupied_and_lone_ones_do_not():
    center = np.array([[15.5, 0.5, 0.5]], dtype=np.float32) * RESOLUTION
    hits = [(15, 0, 0), (15, 1, 0)]
    assert free_map(hits, [3, 2]).states(center)[0] == OCCUPIED
    assert free_map(hits, [2, 2]).states(center)[0] == FREE
    assert free_map([(15, 0, 0), (15, 4, 0)], [3, 3]).states(center)[0] == FREE, "they are not connected"
    assert free_map([(15, 0, 0)], [5]).states(center)[0] == OCCUPIED


def test_a_lone_return_stops_a_flight_only_when_there_is_no_time_to_wait_for_the_next_sweep():
    lone = free_map([(15, 0, 0)], [1])  # 6 m ahead
    assert safe(lone, 1.5).problem == ""
    assert "a return in 5.3 m" in safe(lone, 4.0).problem
    assert safe(free_map([(15, 8, 0)], [1]), 4.0).problem == "", "it is not in the corridor"
    firm = free_map([(15, 0, 0)], [9])
    assert "occupied" in safe(firm, 1.5).problem


def test_sightings_that_are_not_finite_are_refused():
    nav = voxnav.NavigationMap()
    none, thing = np.zeros((0, 3), dtype=np.int32), np.full((1, 12), np.nan)
    with pytest.raises(ValueError, match="not finite"):
        nav.set_sightings(1.0, RESOLUTION, none, np.zeros(0, dtype=np.int32), thing)
    with pytest.raises(ValueError, match="resolution"):
        nav.set_sightings(1.0, 0.0, none, np.zeros(0, dtype=np.int32), np.zeros((0, 12)))


def test_a_goal_that_something_crosses_is_kept_and_reached_when_it_is_gone():
    flight = CrossedFlight((8.0, -2.5, 0.0), (0.0, 0.35, 0.0))
    flight.look()
    flight.tell()
    assert flight.manager.set_goal((8.0, 0.0, 0.0), None, flight.now) == ""
    reasons = set()

    def is_there(f):
        reasons.add(f.manager.status["reason"])
        return f.manager.status["is_goal_reached"]

    assert flight.fly(40.0, is_there), reasons
    assert any("something that moves is at the goal" in reason for reason in reasons), reasons
    assert flight.nearest_m > 0.6
