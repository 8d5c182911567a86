# SPDX-License-Identifier: BSD-3-Clause
"""mapplan.launch takes the arguments and configurations of MRS, and says what it leaves out."""

import os
import subprocess
import sys

import pytest
import yaml

from voxnav.octomap_face import cli
from voxnav.octomap_face.keys import PLANNER, SERVER, Becomes
from voxnav.octomap_face.translate import translate

roslaunch = pytest.importorskip("roslaunch")
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SENSORS = ["lidar", "rplidar", "rs_front", "rs_down"]
# Arguments of mapplan.launch in mrs_octomap_mapping_planning (master).
THEIR_ARGUMENTS = {"UAV_NAME", "LOGGER_DEBUG", "standalone", "debug", "nodelet_manager_name", "world_frame_id",
                   "config_pcl_filter_ouster", "config_pcl_filter_rs_front", "config_pcl_filter_rs_down",
                   "config_octomap_server", "config_octomap_planner", "config_octomap_visualizer"}
# Keys as in the example session of mrs_octomap_mapping_planning, with other values.
SERVER_YAML = """
resolution: 0.2
persistency: {enabled: true, map_name: hall, align_altitude: {enabled: true, robot_height: 0.5}}
local_map: {publisher_rate: 5.0, size: {max_width: 50}}
global_map: {publisher_rate: 0.5}
sensor_params:
  3d_lidar: {n_sensors: 1, sensor_0: {max_range: 30.0, vertical_fov_angle: deg(90.0)}}
  depth_camera: {n_sensors: 1, sensor_0: {max_range: 7.0}, sensor_1: {max_range: 8.0}}
  2d_lidar: {n_sensors: 1, sensor_0: {max_range: 9.0}}
sensor_model: {hit: 0.95}
"""
PLANNER_YAML = """
safe_obstacle_distance: {default: 1.4, min: 0.7, max: 4.0}
max_altitude: 30.0
distance_penalty: 1.0
trajectory_generator: {heading_offset: 0.5, turn_in_flight_direction: true}
a_key_of_tomorrow: 1
"""
FILTER_YAML = "lidar3d: {downsampling: {row_step: 2, col_step: 4}, clip: {range: {use: true, min: 0.9, max: 40}}}"


@pytest.fixture
def loaded(tmp_path, monkeypatch):
    """Returns a function that loads mapplan.launch with arguments."""
    monkeypatch.setenv("UAV_NAME", "uav1")
    monkeypatch.setenv("RUN_TYPE", "simulation")
    monkeypatch.setenv("ROS_HOME", str(tmp_path / "ros_home"))
    path = os.path.join(ROOT, "launch", "mapplan.launch")
    return lambda *arguments: roslaunch.config.load_config_default([(path, list(arguments))], None, verbose=False,
                                                                   assign_machines=False)


def write(path, text):
    path.write_text(text)
    return str(path)


def test_it_has_every_argument_of_theirs():
    from xml.etree import ElementTree
    tree = ElementTree.parse(os.path.join(ROOT, "launch", "mapplan.launch"))
    assert THEIR_ARGUMENTS <= {arg.get("name") for arg in tree.getroot().findall("arg") if arg.get("value") is None}


def test_nodes_and_topics_have_their_names(loaded):
    config = loaded()
    nodes = {node.name: dict(node.remap_args) for node in config.nodes}
    assert set(nodes) >= {"uav1_mapping_nodelet_manager", "octomap_server", "octomap_planner", "local_mapper",
                          "submap_integrator", "planning_manager", "depth_cloud_rs_front", "laser_scan_cloud"}
    assert "bumper" not in nodes and "bumper" in {node.name for node in loaded("bumper:=true").nodes}
    assert nodes["local_mapper"]["~octomap_out"] == "octomap_server/octomap_local_full"
    assert nodes["submap_integrator"]["~octomap_out"] == "octomap_server/octomap_global_full"
    assert config.params["/uav1/planning_manager/heading/mode"].value == "flight_direction"
    assert config.params["/uav1/local_mapper/node/sensors"].value == ["lidar", "rs_front"]
    # The section of an unused camera is there, and without this the mapper would refuse to start with it.
    assert config.params["/uav1/local_mapper/node/idle_sensors"].value == ["rplidar", "rs_down"]
    assert "/uav1/local_mapper/rs_down/max_range_m" in config.params
    assert {node.namespace for node in loaded("UAV_NAME:=uav7").nodes} == {"/uav7/"}


def test_it_does_not_start_without_a_run_type(loaded, monkeypatch):
    monkeypatch.delenv("RUN_TYPE")
    with pytest.raises(roslaunch.core.RLException, match="RUN_TYPE_must_be_realworld_or_simulation"):
        loaded()


def test_their_configurations_become_parameters(loaded, tmp_path):
    config = loaded("config_octomap_server:=" + write(tmp_path / "server.yaml", SERVER_YAML),
                    "config_octomap_planner:=" + write(tmp_path / "planner.yaml", PLANNER_YAML),
                    "config_pcl_filter_ouster:=" + write(tmp_path / "ouster.yaml", FILTER_YAML),
                    "config_pcl_filter_rs_front:=" + write(tmp_path / "front.yaml", FILTER_YAML),
                    "lidars:=rear=rear_os/points")
    expected = {
        "local_mapper/map/resolution_m": 0.2, "submap_integrator/collection/resolution_m": 0.2,
        "octomap_server/node/loads_at_start": True, "octomap_server/node/map_name": "hall",
        "octomap_server/node/autosave_period_s": 10.0, "octomap_server/node/aligns_altitude": True,
        "octomap_server/node/robot_height_m": 0.5, "local_mapper/node/octomap_period_s": 0.2,
        "submap_integrator/node/octomap_period_s": 2.0, "local_mapper/lidar/max_range_m": 30.0,
        "local_mapper/rs_front/max_range_m": 7.0, "local_mapper/rplidar/max_range_m": 9.0,
        "local_mapper/node/sensors": ["lidar", "rplidar", "rear", "rs_front"],
        "planning_manager/planner/safety_distance_m": 1.4, "octomap_planner/node/min_safety_distance_m": 0.7,
        "octomap_planner/node/max_safety_distance_m": 4.0, "planning_manager/map/max_altitude_m": 30.0,
        "planning_manager/heading/offset_rad": 0.5, "cloud_filter/filter/min_range_m": 0.9,
        "cloud_filter/filter/row_decimation": 2, "depth_cloud_rs_front/depth/column_step": 4,
        "cloud_filter_rs_front/filter/max_range_m": 40.0,
    }
    assert {name: config.params["/uav1/" + name].value for name in expected} == expected
    notes = config.params["/uav1/octomap_config_notes"].value
    for text in ("local_map/size/max_width", "sensor_model/hit", "distance_penalty", "a_key_of_tomorrow"):
        assert text in notes
    assert "has no counterpart in voxnav" in notes and "vertical_fov_angle" not in notes


def test_every_parameter_that_a_key_becomes_exists():
    from voxnav import parameters
    program = parameters.describing_program()
    if program is None:
        pytest.skip("describe_parameters is not built: no ROS workspace")
    known = dict(parameters.nodelet_parameters(program), **parameters.python_parameters())
    targets = [target for rules in (SERVER, PLANNER) for rule in rules.values() if isinstance(rule, Becomes)
               for target in rule.targets]
    assert len(targets) > 25
    for target in targets:
        node, section, name = target.replace("SENSOR", "lidar").split("/")
        assert name in {field["name"] for field in known[node][section]}, target


@pytest.mark.parametrize("text,mode", [("{}", "flight_direction"),
                                       ("trajectory_generator: {use_heading: false}", "fixed"),
                                       ("trajectory_generator: {turn_in_flight_direction: false}", "goal")])
def test_the_heading_follows_their_switches(text, mode):
    done = translate(None, yaml.safe_load(text), {}, SENSORS)
    assert done.parameters["planning_manager"]["heading"]["mode"] == mode


def test_a_map_is_saved_and_loaded_only_if_persistency_is_on():
    off = translate({"persistency": {"enabled": False, "save_time": 5.0}}, None, {}, SENSORS).parameters
    assert "autosave_period_s" not in off["octomap_server"]["node"]
    on = translate({"persistency": {"enabled": True, "save_time": 5.0}}, None, {}, SENSORS).parameters
    assert on["octomap_server"]["node"] == {"loads_at_start": True, "autosave_period_s": 5.0}


@pytest.mark.parametrize("text,reason", [
    ("- a list", "holds no parameters"), ("sensor_params: 3", "holds no parameters"),
    ("resolution: wide", "resolution: 'wide' cannot be used"), ("local_map: {publisher_rate: 0}", "cannot be used"),
    ("sensor_params: {3d_lidar: {n_sensors: two}}", "n_sensors of 3d_lidar is 'two'"), ("a: [", "server.yaml")])
def test_a_broken_configuration_ends_the_launch_with_a_reason(text, reason, tmp_path, capsys):
    given = write(tmp_path / "server.yaml", text)
    assert cli.run(["--server", given, "--out", str(tmp_path / "out.yaml")]) == 1
    assert reason in capsys.readouterr().err


def test_a_configuration_that_is_not_there_ends_the_launch(loaded, tmp_path):
    with pytest.raises(roslaunch.core.RLException, match="octomap_config"):
        loaded("config_octomap_server:=" + str(tmp_path / "nowhere.yaml"))


def test_the_command_writes_beside_nothing_else(tmp_path):
    """The script runs as mapplan.launch runs it, with empty arguments where no file is given."""
    out = tmp_path / "new" / "out.yaml"
    subprocess.check_call([sys.executable, os.path.join(ROOT, "scripts", "octomap_config"), "--server", "", "--planner",
                           "", "--filter", "lidar=", "--sensors", "lidar", "--out", str(out)])
    assert yaml.safe_load(out.read_text())["local_mapper"]["node"]["sensors"] == ["lidar"]
