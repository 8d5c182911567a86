# SPDX-License-Identifier: BSD-3-Clause
"""Starts rviz with a view of this package for the UAV of any name, and with what mrs_rviz_plugins adds where it is."""

import os
import sys
import tempfile

import rospkg
import yaml

WRITTEN_FOR = "uav1"
VIEWS = ("planning", "mapping", "graph")


def displays_of_mrs(uav_name):
    """Returns the displays that need mrs_rviz_plugins: the model of its load_robot.launch, and what the bumper sees."""
    return [{"Class": "rviz/RobotModel", "Name": "UAV", "Enabled": True, "Value": True,
             "Robot Description": uav_name + "/robot_model"},
            {"Class": "mrs_rviz_plugins/Bumper", "Name": "Bumper", "Enabled": False, "Value": False,
             "Topic": "/%s/bumper/obstacle_sectors" % uav_name}]


def view_for(text, uav_name, has_mrs_plugins):
    """Returns the configuration of rviz for a UAV. text: that for the UAV for which the file was written."""
    view = yaml.safe_load(text.replace(WRITTEN_FOR + "/", uav_name + "/"))
    if has_mrs_plugins:
        view["Visualization Manager"]["Displays"] += displays_of_mrs(uav_name)
    return yaml.safe_dump(view, sort_keys=False)


def has_package(name):
    try:
        rospkg.RosPack().get_path(name)
    except rospkg.ResourceNotFound:
        return False
    return True


def main():
    """Replaces this process by rviz. Arguments: VIEW UAV_NAME, and any that rviz takes."""
    if len(sys.argv) < 3 or sys.argv[1] not in VIEWS:
        print("usage: rviz_view %s UAV_NAME [ARGUMENTS OF RVIZ]" % "|".join(VIEWS), file=sys.stderr)
        return 2
    name, uav_name = sys.argv[1:3]
    source = os.path.join(rospkg.RosPack().get_path("voxnav"), "rviz", name + ".rviz")
    with open(source, encoding="utf-8") as view:
        text = view_for(view.read(), uav_name, has_package("mrs_rviz_plugins"))
    with tempfile.NamedTemporaryFile("w", prefix="voxnav_%s_" % uav_name, suffix=".rviz", delete=False) as out:
        out.write(text)
    return os.execvp("rviz", ["rviz", "-d", out.name] + sys.argv[3:])
