# SPDX-License-Identifier: BSD-3-Clause
"""The views of rviz follow the name of the UAV, and show what mrs_rviz_plugins adds where it is installed."""

import os

import pytest
import yaml

rviz_view = pytest.importorskip("voxnav.nodes.rviz_view")
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def text_of(name):
    with open(os.path.join(ROOT, "rviz", name + ".rviz"), encoding="utf-8") as source:
        return source.read()


def test_every_view_can_be_asked_for():
    names = {os.path.splitext(name)[0] for name in os.listdir(os.path.join(ROOT, "rviz"))}
    assert names == set(rviz_view.VIEWS)


@pytest.mark.parametrize("name", rviz_view.VIEWS)
def test_a_view_follows_the_name_of_the_uav_and_nothing_else_changes(name):
    view = rviz_view.view_for(text_of(name), "uav7", has_mrs_plugins=False)
    assert "uav1" not in view and view.count("uav7/") == text_of(name).count("uav1/") > 3
    assert yaml.safe_load(view.replace("uav7/", "uav1/")) == yaml.safe_load(text_of(name))


@pytest.mark.parametrize("name", rviz_view.VIEWS)
def test_displays_of_mrs_are_added_where_their_package_is(name):
    few, more = (yaml.safe_load(rviz_view.view_for(text_of(name), "uav7", has))["Visualization Manager"]["Displays"]
                 for has in (False, True))
    assert more[:len(few)] == few
    assert [each["Class"] for each in more[len(few):]] == ["rviz/RobotModel", "mrs_rviz_plugins/Bumper"]
    assert more[-2]["Robot Description"] == "uav7/robot_model"
    assert more[-1]["Topic"] == "/uav7/bumper/obstacle_sectors"
