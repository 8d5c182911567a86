# SPDX-License-Identifier: BSD-3-Clause
"""Launch files can be loaded, and rviz shows topics that a node publishes."""

import os
import re

import pytest
import yaml

roslaunch = pytest.importorskip("roslaunch")
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
ARGUMENTS = {"nodes": ["UAV_NAME:=uav1"], "voxnav": ["UAV_NAME:=uav1"], "bag": [], "simulation": []}
NODES = {"cloud_filter", "local_mapper", "submap_integrator", "submap_optimizer", "planning_manager"}


def loaded(name, *arguments):
    path = os.path.join(ROOT, "launch", name + ".launch")
    os.environ.setdefault("BOND", "")
    return roslaunch.config.load_config_default([(path, ARGUMENTS[name] + list(arguments))], None, verbose=False,
                                                assign_machines=False)


def nodes_of(config):
    return {node.name for node in config.nodes}


@pytest.mark.parametrize("name", sorted(ARGUMENTS))
def test_launch_files_start_their_nodes(name):
    assert nodes_of(loaded(name)) >= NODES - ({"planning_manager"} if name == "bag" else set())


def test_the_launch_file_has_the_arguments_of_mrs_launch_files():
    standalone = loaded("voxnav", "standalone:=true")
    assert all("standalone" in node.args for node in standalone.nodes if node.package == "nodelet")
    assert "voxnav_nodelet_manager" not in nodes_of(standalone)
    assert "lidar_odometry" in nodes_of(loaded("voxnav", "odometry:=lidar"))
    other = loaded("voxnav", "UAV_NAME:=uav7", "topic_3d_lidar_in:=velodyne_points")
    assert {node.namespace for node in other.nodes} == {"/uav7/"}
    remaps = [pair for node in other.nodes if node.name == "cloud_filter" for pair in node.remap_args]
    assert any(pair[1].endswith("velodyne_points") for pair in remaps)


def arguments_of(config, node):
    return next(each for each in config.nodes if each.name == node).args


@pytest.mark.parametrize("name", ["nodes", "voxnav", "bag"])
def test_further_sensors_have_nodes_of_their_own_and_reach_the_mapper(name):
    one = loaded(name)
    assert one.params["/uav1/local_mapper/node/sensors"].value == ["lidar"]
    more = loaded(name, "lidars:=rear=rear_os/points left=/x/points", "depth_cameras:=front=front/depth/image_rect_raw")
    assert nodes_of(more) - nodes_of(one) == {"cloud_filter_rear", "cloud_filter_left", "cloud_filter_front",
                                              "depth_cloud_front"}
    assert more.params["/uav1/local_mapper/node/sensors"].value == ["lidar", "rear", "left", "front"]
    assert more.params["/uav1/local_mapper/front/max_range_m"].value == 6.0
    for sensor in ("rear", "left", "front"):
        remap = "~%s/points_in:=cloud_filter_%s/points" % (sensor, sensor)
        assert remap in arguments_of(more, "local_mapper").split()
    remaps = {node.name: dict(node.remap_args) for node in more.nodes}
    assert remaps["cloud_filter_left"]["~cloud_in"] == "/x/points"
    assert remaps["depth_cloud_front"]["~camera_info_in"] == "front/depth/camera_info"
    assert remaps["cloud_filter_front"]["~cloud_in"] == "depth_cloud_front/cloud"


def test_the_simulation_waits_for_its_further_sensors():
    config = loaded("simulation", "tilted_lidar:=true", "front_camera:=true", "lockstep:=true")
    waited = config.params["/uav1/uav_simulator/node/lockstep_nodes"].value
    assert set(waited) >= {"lidar_simulator_tilted", "depth_camera_simulator", "local_mapper/tilted",
                           "local_mapper/front"}
    assert {name for name in waited if "/" not in name} <= nodes_of(config)
    assert config.params["/uav1/cloud_filter_tilted/filter/ghost_intensity"].value == 20.0


def test_faults_are_simulated_only_when_they_are_asked_for(tmp_path):
    with open(os.path.join(ROOT, "config", "faults.yaml")) as source:
        faults = yaml.safe_load(source)
    expected = {"/uav1/%s/%s/%s" % (node, section, name): value for node, sections in faults.items()
                for section, values in sections.items() for name, value in values.items()}
    usual, hard = loaded("simulation").params, loaded("simulation", "faults:=true").params
    assert expected and {name for name in hard if name not in usual or hard[name].value != usual[name].value} \
        == set(expected)
    assert {name: hard[name].value for name in expected} == expected
    own = str(tmp_path / "own.yaml")
    with open(own, "w") as out:
        out.write("lidar_simulator: {lidar: {speckle_ratio: 0.5}}\n")
    both = loaded("simulation", "faults:=true", "custom_config:=" + own).params
    assert both["/uav1/lidar_simulator/lidar/speckle_ratio"].value == 0.5


def test_time_of_services_passes_where_it_can():
    services, losses = "/uav1/uav_simulator/services/is_enabled", "/uav1/lidar_simulator/node/loss_ratio"
    free = loaded("simulation", "faults:=true").params
    waiting = loaded("simulation", "faults:=true", "lockstep:=true").params
    assert free[services].value and not waiting[services].value
    assert waiting[losses].value > 0.0
    told = [waiting["/uav1/lidar_simulator/node/" + name].value for name in ("waiting_nodes", "acting_nodes")]
    assert told == [["cloud_filter", "local_mapper"], ["planning_manager"]]
    assert set(sum(told, [])) <= set(waiting["/uav1/uav_simulator/node/lockstep_nodes"].value)
    several = loaded("simulation", "faults:=true", "lockstep:=true", "tilted_lidar:=true").params
    assert several[losses].value == 0.0


@pytest.mark.parametrize("asked, initial, limit", [("", "medium", 8.0), ("2", "medium", 2.0), ("4.0", "medium", 4.0),
                                                   ("6", "fast", 6.0)])
def test_a_speed_limit_chooses_the_constraints(asked, initial, limit):
    params = loaded("simulation", "max_speed_mps:=" + asked).params
    assert params["/uav1/uav_simulator/constraints/initial"].value == initial
    assert params["/uav1/uav_simulator/constraints/max_speed_mps"].value == limit


@pytest.mark.parametrize("run_type", [None, "", "realworld", "uav", "Simulation", "simulation"])
def test_time_is_simulated_only_where_run_type_is_simulation(run_type, monkeypatch):
    monkeypatch.delenv("RUN_TYPE", raising=False)
    if run_type is not None:
        monkeypatch.setenv("RUN_TYPE", run_type)
    params = loaded("voxnav").params
    if run_type == "simulation":
        assert params["/use_sim_time"].value is True
    else:
        assert "/use_sim_time" not in params


def test_a_custom_configuration_wins(tmp_path):
    path = str(tmp_path / "own.yaml")
    with open(path, "w") as out:
        out.write("local_mapper: {map: {resolution_m: 0.2}}\n")
    for name in ("voxnav", "simulation"):
        config = loaded(name, "custom_config:=" + path)
        assert config.params["/uav1/local_mapper/map/resolution_m"].value == 0.2
        assert config.params["/uav1/local_mapper/map/max_range_m"].value == 26.0


def published():
    out = set()
    for node in loaded("simulation").nodes:
        for source, target in node.remap_args:
            if re.search(r"(_out|_in)$", source):
                out.add(target.replace("~", "/uav1/%s/" % node.name))
    return out


@pytest.mark.parametrize("name", ["planning", "mapping", "graph"])
def test_rviz_shows_topics_that_exist(name):
    topics = [d.get("Topic", d.get("Marker Topic")) for d in displays(name)]
    topics = [topic for topic in topics if topic]
    assert len(topics) >= 3
    assert set(topics) <= published()


def displays(name):
    with open(os.path.join(ROOT, "rviz", name + ".rviz")) as source:
        return yaml.safe_load(source)["Visualization Manager"]["Displays"]


@pytest.mark.parametrize("name", ["planning", "mapping"])
def test_everything_coloured_by_height_has_one_scale(name):
    with open(os.path.join(ROOT, "config", "submap_integrator.yaml")) as source:
        markers = yaml.safe_load(source)["node"]
    clouds = [d for d in displays(name) if d.get("Color Transformer") == "AxisColor"]
    assert clouds
    for display in clouds:
        bounds = display["Autocompute Value Bounds"]
        assert not bounds["Value"], display["Name"] + ": bounds that follow the cloud are another scale"
        assert (bounds["Min Value"], bounds["Max Value"]) == (markers["color_min_m"], markers["color_max_m"])
        assert display["Axis"] == "Z" and display["Use rainbow"] and display.get("Use Fixed Frame", True)


def test_the_tmux_session_uses_files_and_arguments_that_exist():
    directory = os.path.join(ROOT, "tmux", "forest")
    with open(os.path.join(directory, "session.yml")) as source:
        text = source.read()
    yaml.safe_load(text)
    for path in re.findall(r"\./(config/[\w.]+)|`pwd`/(config/[\w.]+)", text):
        assert os.path.exists(os.path.join(directory, max(path)))
    command = re.search(r"roslaunch voxnav (\w+)\.launch(.*)", text)
    arguments = [word for word in command.group(2).split() if ":=" in word]
    own = os.path.join(directory, "config", "voxnav.yaml")
    loaded(command.group(1), *[re.sub(":=.*voxnav.yaml", ":=" + own, word) for word in arguments])
