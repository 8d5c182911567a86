# SPDX-License-Identifier: BSD-3-Clause
"""The search of parameters finds better ones, does not fly the same twice, and goes on after interruptions."""

import os
import re
import sys

import pytest
import yaml

import campaign_fakes
from voxnav.campaign import cli
from voxnav.campaign.errors import CampaignError
from voxnav.campaign.rows import FlightRow
from voxnav.campaign.search import merged, read_space, score, trial_folder

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SPACE = """
min_clearance_m: 1.0
parameters:
  planning_manager:
    manager:
      deceleration_ratio: {low: 0.4, high: 0.9, step: 0.1}
"""
RATIO = "planning_manager/manager/deceleration_ratio"


def space_file(tmp_path, text=SPACE):
    path = tmp_path / "space.yaml"
    path.write_text(text)
    return str(path)


def search(tmp_path, trials):
    pytest.importorskip("optuna")
    pytest.importorskip("distributed")
    return cli.main(["--worlds", "grove", "--seeds", "1,2", "--workers", "1", "--out", str(tmp_path / "out"),
                     "--search", space_file(tmp_path), "--trials", str(trials)], campaign_fakes.fly_with_ratio)


def test_a_space_is_read(tmp_path):
    space = read_space(space_file(
        tmp_path, SPACE + "  local_mapper:\n    map:\n      resolution_m: {choices: [0.3, 0.4]}\nseed: 4\n"))
    assert space.parameters == {RATIO: {"low": 0.4, "high": 0.9, "step": 0.1},
                                "local_mapper/map/resolution_m": {"choices": [0.3, 0.4]}}
    assert space.min_clearance_m == 1.0 and space.seed == 4


@pytest.mark.parametrize("text", ["", "parameters: {}", "parameters: {a: 1.0}", "parameters: {a: {low: 1}}",
                                  "parameters: {a: {low: 1, high: 2, middle: 3}}",
                                  "parameter: {a: {low: 1, high: 2}}", "parameters: [", "min_clearance_m: 1.0"])
def test_spaces_that_cannot_be_read_are_refused(tmp_path, text):
    with pytest.raises(CampaignError):
        read_space(space_file(tmp_path, text))


@pytest.mark.parametrize("name,problem", [
    ("planning_manager: {manager: {decelerate", "no parameter manager/decelerate"),
    ("pilot: {manager: {a", "no node pilot")])
def test_parameters_that_no_node_has_are_refused_before_anything_flies(tmp_path, name, problem):
    with pytest.raises(CampaignError, match=problem):
        read_space(space_file(tmp_path, "parameters: {%s: {low: 1, high: 2}}}}" % name))


def test_the_documented_space_is_the_example_and_can_be_read():
    example = os.path.join(ROOT, "docs", "examples", "search_planner.yaml")
    assert len(read_space(example).parameters) == 2
    with open(example) as source, open(os.path.join(ROOT, "docs", "campaign.md")) as page:
        text = source.read().split("\n", 2)[2]  # without the lines about the file itself
        assert re.findall(r"```yaml\n(.*?)```", page.read(), re.DOTALL) == [text]


def test_values_go_into_the_configuration():
    text = merged("planner:\n  search: {weight: 1.0, limit: 5}\n", {"planner/search/weight": 1.2, "cloud_filter/a": 3})
    assert yaml.safe_load(text) == {"planner": {"search": {"weight": 1.2, "limit": 5}}, "cloud_filter": {"a": 3}}
    assert yaml.safe_load(merged("", {"a/b": True})) == {"a": {"b": True}}


def test_trials_of_equal_values_share_a_folder():
    assert trial_folder({"a": 1.0, "b": 2}) == trial_folder({"b": 2, "a": 1.0}) != trial_folder({"a": 1.1, "b": 2})


def test_a_flight_that_fails_or_comes_too_near_scores_nothing():
    good = FlightRow(0, 300.0, 4.0, True, "goal reached", 1.25, 1.07, 3.0, collided=False)
    assert score([good], 1.0) == 3.0
    assert score([good, good._replace(min_clearance_m=0.9)], 1.0) == 1.5
    assert score([good, FlightRow(0, 300.0, 4.0, reason="crashed")], 0.0) == 1.5
    assert score([good._replace(collided=True)], 0.0) == 0.0


def test_a_search_finds_what_is_fastest_and_safe(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("VOXNAV_TEST_FLOWN", str(tmp_path / "flown"))
    assert search(tmp_path, 6) == 0
    assert search(tmp_path, 14) == 0
    best = yaml.safe_load((tmp_path / "out" / "best.yaml").read_text())
    assert best["planning_manager"]["manager"]["deceleration_ratio"] == pytest.approx(0.7)
    assert "trial 14 of 14" in capsys.readouterr().out
    num_folders = len(list((tmp_path / "out" / "trials").iterdir()))
    assert num_folders <= 6  # so many values there are
    assert len((tmp_path / "flown").read_text().splitlines()) == 2 * num_folders


def test_an_interrupted_trial_is_taken_up_again(tmp_path):
    optuna = pytest.importorskip("optuna")
    assert search(tmp_path, 1) == 0

    def load():
        return optuna.load_study(study_name="voxnav", storage="sqlite:///%s" % (tmp_path / "out" / "study.db"))
    study = load()
    study.enqueue_trial({RATIO: 0.7})
    study.ask({RATIO: optuna.distributions.FloatDistribution(0.4, 0.9, step=0.1)})
    assert search(tmp_path, 2) == 0
    states = [(trial.state.name, trial.params) for trial in load().get_trials()]
    assert states[1] == ("FAIL", {RATIO: 0.7})
    assert states[2] == ("COMPLETE", {RATIO: 0.7})


def test_a_machine_without_optuna_names_the_package(tmp_path, capsys, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setitem(sys.modules, "optuna", None)
    assert cli.main(["--worlds", "grove", "--seeds", "1", "--workers", "1", "--out", str(tmp_path / "out"), "--search",
                     space_file(tmp_path)], campaign_fakes.fly_with_ratio) == 1
    assert "python3-optuna" in capsys.readouterr().err
