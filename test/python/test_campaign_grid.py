# SPDX-License-Identifier: BSD-3-Clause
"""The grid of a campaign has every flight once, in balanced order; bad input is refused with what was expected."""

import collections

import pytest
import yaml

from voxnav.campaign import grid
from voxnav.campaign.errors import CampaignError
from voxnav.campaign.worlds import WorldText, read_world, with_density

WORLD = read_world("grove")
LIKE = grid.FlightTask(WORLD, 0, None, False, config="a: 1", limit_s=7.0)


def grid_of(num_seeds, densities=(100.0, 300.0, 450.0, 600.0), speeds=(2.0, 4.0, 6.0), faults=(False,)):
    return grid.Grid((WORLD,), tuple(range(1000, 1000 + num_seeds)), densities, speeds, faults)


def test_seeds_and_numbers_are_read():
    assert grid.seeds("1000-1003") == (1000, 1001, 1002, 1003)
    assert grid.seeds("1, 2,7-9") == (1, 2, 7, 8, 9)
    assert grid.numbers("2,4.5", "speed", 0.1) == (2.0, 4.5)


@pytest.mark.parametrize("text", ["", "a", "5-3", "1-", "-3", "1.5", "1,1", "3,1-4", "0-999999999999"])
def test_bad_seeds_are_refused(text):
    with pytest.raises(CampaignError, match="seed"):
        grid.seeds(text)


@pytest.mark.parametrize("text", ["", "x", "nan", "inf", "0", "-2", "2,2.0"])
def test_bad_speeds_are_refused(text):
    with pytest.raises(CampaignError, match="speed"):
        grid.numbers(text, "speed", 0.1)


@pytest.mark.parametrize("num_seeds", [1, 5, 12, 25])
def test_every_flight_of_the_grid_comes_once(num_seeds):
    flown = grid_of(num_seeds, faults=(False, True))
    tasks = list(flown.tasks(LIKE))
    assert len(tasks) == flown.num_flights == num_seeds * 24
    assert len({task.name for task in tasks}) == len(tasks)
    assert {(t.config, t.limit_s) for t in tasks} == {("a: 1", 7.0)}


def test_the_first_flights_have_different_seeds_and_use_everything_equally_often():
    tasks = list(grid_of(100).tasks(LIKE))[:96]
    assert len({task.seed for task in tasks}) == 96
    counts = collections.Counter((task.world.trees_per_ha, task.speed_mps) for task in tasks)
    assert len(counts) == 12 and set(counts.values()) == {8}


def test_a_huge_grid_is_refused():
    with pytest.raises(CampaignError, match="1200000 flights"):
        next(grid_of(100000).tasks(LIKE))


def test_a_world_gets_another_density_and_stays_what_it_is():
    changed = with_density(WORLD, 450.0)
    assert changed.trees_per_ha == 450.0 and changed.name == "grove"
    before, after = yaml.safe_load(WORLD.text), yaml.safe_load(changed.text)
    assert after == dict(before, trees_per_ha=450.0)
    assert with_density(WORLD, None) == WORLD == with_density(WORLD, 300.0)


def test_the_simulator_reads_a_world_with_another_density(tmp_path):
    simulation = pytest.importorskip("voxnav.simulation")
    num_trees = {}
    for density in (50.0, 300.0):
        path = tmp_path / ("%g.yaml" % density)
        path.write_text(with_density(WORLD, density).text)
        num_trees[density] = simulation.World(str(path), seed=1).counts["trees"]
    assert 0 < num_trees[50.0] < 0.3 * num_trees[300.0]


def test_worlds_that_cannot_be_are_refused(tmp_path):
    with pytest.raises(CampaignError, match="no world nowhere"):
        grid.worlds("nowhere")
    with pytest.raises(CampaignError, match="given twice"):
        grid.worlds("grove,grove")
    path = tmp_path / "flat.yaml"
    path.write_text("size_m: [1.0, 2.0]\n")
    with pytest.raises(CampaignError, match="trees_per_ha"):
        read_world(str(path))
    pytest.importorskip("voxnav.simulation")
    with pytest.raises(CampaignError, match="trees_per_ha"):
        with_density(WORLD, 1e9)
    broken = WorldText("odd", WORLD.text + "trees_per_hectare: 3\n", 300.0)
    with pytest.raises(CampaignError, match="trees_per_hectare"):
        with_density(broken, 100.0)
