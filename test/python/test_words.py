# SPDX-License-Identifier: BSD-3-Clause
"""Enums of the core in Python have members that compare equal to their words."""

import copy
import json
import pickle

import numpy as np
import pytest

import voxnav


def test_configurations_take_members_and_words_and_give_members():
    for given in ("penalise", voxnav.UnknownPolicy.PENALISE):
        config = voxnav.AStarConfig(unknown_policy=given)
        assert config.unknown_policy is voxnav.UnknownPolicy.PENALISE
    config.unknown_policy = voxnav.UnknownPolicy.OPTIMISTIC_FAR
    assert config.unknown_policy is voxnav.UnknownPolicy.OPTIMISTIC_FAR
    config.unknown_policy = "forbid"
    assert config.unknown_policy is voxnav.UnknownPolicy.FORBID


def test_yaml_and_documentation_use_words():
    config = voxnav.AStarConfig(unknown_policy=voxnav.UnknownPolicy.PENALISE)
    assert type(config.to_dict()["unknown_policy"]) is str and config.to_dict()["unknown_policy"] == "penalise"
    row = [field for field in voxnav.AStarConfig.describe() if field["name"] == "unknown_policy"][0]
    assert row["default"] == "forbid" and row["choices"] == ["forbid", "penalise", "optimistic_far"]
    assert "unknown_policy='penalise'" in repr(config)


def test_unknown_words_are_refused_with_what_is_allowed():
    with pytest.raises(voxnav.ConfigError, match="'hope': allowed is one of forbid, penalise, optimistic_far"):
        voxnav.AStarConfig(unknown_policy="hope")
    with pytest.raises(voxnav.ConfigError, match="needs a string"):
        voxnav.AStarConfig(unknown_policy=1)
    with pytest.raises(ValueError, match="hope"):
        voxnav.UnknownPolicy("hope")


def test_members_print_and_compare_as_their_words():
    member = voxnav.PlanStatus.NO_PATH
    assert member == "no_path" and member.value == "no_path" and hash(member) == hash("no_path")
    assert str(member) == "%s" % member == "{}".format(member) == f"{member}" == "no_path"
    assert repr(member) == "<PlanStatus.NO_PATH: 'no_path'>"
    assert json.dumps({member: member}) == '{"no_path": "no_path"}'
    assert voxnav.PlanStatus("no_path") is member
    assert [str(status) for status in voxnav.PlanStatus][:2] == ["complete", "partial_timeout"]


def test_members_survive_pickling_and_copying():
    member = voxnav.ConstraintKind.LOOP
    assert pickle.loads(pickle.dumps(member)) is member
    assert copy.deepcopy(member) is member


def test_results_give_members():
    grid = voxnav.StateGrid(1.0)
    result = voxnav.AStarPlanner().plan(grid, (0.0, 0.0, 0.0), (np.nan, 0.0, 0.0))
    assert result.status is voxnav.PlanStatus.INVALID_INPUT


def test_constraint_kinds_are_taken_as_members_or_words():
    graph = voxnav.SubmapGraph()
    for i in range(3):
        graph.add_submap(i, np.eye(4))
    graph.add_relative_pose(0, 1, np.eye(4), np.eye(4), kind="loop")
    graph.add_relative_pose(1, 2, np.eye(4), np.eye(4), kind=voxnav.ConstraintKind.LOOP)
    assert [c[0] for c in graph.constraints()] == [voxnav.ConstraintKind.LOOP] * 2
    assert graph.constraints()[0][0] is voxnav.ConstraintKind.LOOP
    report = graph.optimize()
    assert report.num_constraints["loop"] == report.num_constraints[voxnav.ConstraintKind.LOOP]
    assert list(report.costs) == list(voxnav.ConstraintKind)
    with pytest.raises(ValueError, match="kind must be odometry, registration, loop, gnss or height, got 'magic'"):
        graph.add_relative_pose(0, 2, np.eye(4), np.eye(4), kind="magic")
    with pytest.raises(ValueError, match="odometry or loop"):
        graph.add_relative_pose(0, 2, np.eye(4), np.eye(4), kind=voxnav.ConstraintKind.GNSS)
