# SPDX-License-Identifier: BSD-3-Clause
"""The settings of the planner warn of distances that do not suit each other."""

import pytest

import voxnav

pytest.importorskip("rospy", reason="rospy is not installed")
import rospy  # noqa: E402

from voxnav.nodes.planning_settings import PlanningSettings  # noqa: E402

CORRIDOR = dict(corridor_radius_m=0.7, trajectory_deviation_m=0.2)


def warnings_for(monkeypatch, zone_distance_m):
    said = []
    monkeypatch.setattr(rospy, "Service", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: said.append(text % values))
    PlanningSettings(voxnav.FlightSearchConfig(), voxnav.NavigationMapConfig(zone_distance_m=zone_distance_m),
                     voxnav.PlanningManagerConfig(**CORRIDOR), lambda low, high: None)
    return said


def test_a_zone_distance_that_is_less_than_what_is_flown_keeps_is_warned_of(monkeypatch):
    [said] = warnings_for(monkeypatch, 0.5)
    assert said.startswith("map/zone_distance_m 0.50 m is less than the 0.90 m that what is flown may need")


@pytest.mark.parametrize("zone_distance_m", [0.9, 1.0, 3.0])
def test_one_that_suffices_is_not(monkeypatch, zone_distance_m):
    assert warnings_for(monkeypatch, zone_distance_m) == []


def test_the_shipped_configuration_suffices(monkeypatch):
    limits, manager = voxnav.NavigationMapConfig(), voxnav.PlanningManagerConfig()
    assert limits.zone_distance_m >= manager.corridor_radius_m + manager.trajectory_deviation_m
    assert warnings_for(monkeypatch, limits.zone_distance_m) == []
