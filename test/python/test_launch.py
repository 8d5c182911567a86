# SPDX-License-Identifier: BSD-3-Clause
"""Launch files can be loaded, and rviz shows topics that a node publishes."""

import os
import re

import pytest
import yaml

roslaunch = pytest.importorskip("roslaunch")
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
ARGUMENTS = {"nodes": ["UAV_NAME:=uav1"], "voxnav": ["UAV_NAME:=uav1", "RUN_TYPE:=realworld"], "bag": [],
             "simulation": [], "two_uavs": []}
NODES = {"cloud_filter", "local_mapper", "submap_integrator", "submap_optimizer", "planning_manager"}


def loaded(name, *arguments):
    path = os.path.join(ROOT, "launch", name + ".launch")
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


@pytest.mark.parametrize("run_type", [None, "", "uav", "Simulation", "realworld", "simulation"])
def test_it_starts_only_if_it_is_told_whether_the_vehicle_is_real(run_type, monkeypatch):
    monkeypatch.delenv("RUN_TYPE", raising=False)
    monkeypatch.setitem(ARGUMENTS, "voxnav", ["UAV_NAME:=uav1"])
    if run_type is not None:
        monkeypatch.setenv("RUN_TYPE", run_type)
    if run_type not in ("realworld", "simulation"):
        with pytest.raises(roslaunch.core.RLException, match="RUN_TYPE_must_be_realworld_or_simulation"):
            loaded("voxnav")
        return
    params = loaded("voxnav").params
    assert ("/use_sim_time" in params) == (run_type == "simulation")
    assert run_type == "realworld" or params["/use_sim_time"].value is True


def test_a_custom_configuration_wins(tmp_path):
    path = str(tmp_path / "own.yaml")
    with open(path, "w") as out:
        out.write("local_mapper: {map: {resolution_m: 0.2}}\n")
    for name in ("voxnav", "simulation"):
        config = loaded(name, "custom_config:=" + path)
        assert config.params["/uav1/local_mapper/map/resolution_m"].value == 0.2
        assert config.params["/uav1/local_mapper/map/max_range_m"].value == 26.0


@pytest.mark.parametrize("name", ["nodes", "voxnav"])
def test_the_map_is_in_the_frame_of_the_estimator_unless_another_one_is_named(name):
    frame = "/uav1/local_mapper/node/odometry_frame"
    assert loaded(name).params[frame].value == ""
    own = loaded(name, "odometry:=lidar").params
    assert own[frame].value == own["/uav1/lidar_odometry/node/odometry_frame"].value == "uav1/slam_origin"
    assert loaded(name, "odometry_frame:=uav1/rtk_origin").params[frame].value == "uav1/rtk_origin"


def write(path, text):
    path.write_text(text)
    return str(path)


def test_configurations_are_layers_of_which_the_custom_one_wins(tmp_path, monkeypatch):
    layers = ["network", "world", "platform", "custom"]
    for count, layer in enumerate(layers, 1):
        values = ", ".join("%s: %s" % (name, layers.index(layer)) for name in layers[:count])
        write(tmp_path / (layer + ".yaml"), "of_the_test: {%s}\nmrs_uav_managers: {of: %s}\n" % (values, layer))
    arguments = ["%s_config:=%s.yaml" % (layer, layer) for layer in layers]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PWD", str(tmp_path))  # relative paths are those of the shell that called roslaunch
    params = loaded("voxnav", *arguments).params
    assert [params["/uav1/of_the_test/" + layer].value for layer in layers] == [3, 3, 3, 3]
    world = "/uav1/planning_manager/fences/world_config"
    assert params[world].value == str(tmp_path / "world.yaml") and loaded("voxnav").params[world].value == ""
    without = loaded("voxnav", *arguments[:-1]).params
    assert [without["/uav1/of_the_test/" + layer].value for layer in layers[:-1]] == [2, 2, 2]
    for layer in layers:
        monkeypatch.setenv(layer.upper() + "_CONFIG", str(tmp_path / (layer + ".yaml")))
    assert loaded("voxnav").params["/uav1/of_the_test/custom"].value == 3
    with pytest.raises(roslaunch.core.RLException, match="no_such_file"):
        loaded("voxnav", "custom_config:=no_such_file.yaml")


@pytest.mark.parametrize("bond", ["false", "0", "--no-bond"])
def test_without_bonds_every_nodelet_has_a_process_that_is_started_again(bond, monkeypatch):
    """A nodelet notices by its bond alone that its manager died."""
    with_bond = loaded("voxnav", "depth_cameras:=front=front/depth/image_rect_raw")
    monkeypatch.setenv("BOND", bond)
    without = loaded("voxnav", "depth_cameras:=front=front/depth/image_rect_raw")
    assert nodes_of(with_bond) - nodes_of(without) == {"voxnav_nodelet_manager"}
    nodelets = [node for node in without.nodes if node.package == "nodelet"]
    assert len(nodelets) == 5
    for node in nodelets:
        assert node.args.startswith("standalone ") and node.respawn
    for node in with_bond.nodes:
        assert "--no-bond" not in node.args and "false" not in node.args


EVERY_LAUNCH_FILE = {"nodes": ARGUMENTS["nodes"], "voxnav": ARGUMENTS["voxnav"], "bag": [], "simulation": [],
                     "two_uavs": [],
                     "sensors": ["kind:=lidar", "sensors:=rear=/points", "nodelet:=load", "manager:=manager",
                                 "launch_prefix:=nice", "lockstep:=false"],
                     "config": ["file:=" + os.path.join(ROOT, "config", "simulation.yaml")], "rviz": [],
                     "mapplan": ARGUMENTS["voxnav"], "octomap_face": ["UAV_NAME:=uav1", "bumper:=true"]}


def test_every_launch_file_is_known_to_the_next_test():
    names = {os.path.splitext(name)[0] for name in os.listdir(os.path.join(ROOT, "launch"))}
    assert names == set(EVERY_LAUNCH_FILE)


@pytest.mark.parametrize("name", sorted(EVERY_LAUNCH_FILE))
def test_roslaunch_tells_the_nodes_of_every_launch_file_and_the_arguments_of_each(name, capsys, monkeypatch, tmp_path):
    """As `roslaunch --nodes` and `roslaunch --args`, which need the program of every node to exist."""
    node_args = pytest.importorskip("roslaunch.node_args")
    monkeypatch.setenv("ROS_HOME", str(tmp_path))  # mapplan.launch writes there
    files = [(os.path.join(ROOT, "launch", name + ".launch"), EVERY_LAUNCH_FILE[name])]
    node_args.print_node_list(files)
    names = capsys.readouterr().out.split()
    assert bool(names) == (name != "config")
    for node in names:
        node_args.print_node_args(node, files)
        words = capsys.readouterr().out.split()
        assert "__name:=" + node.split("/")[-1] in words and any(os.access(word, os.X_OK) for word in words)


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


# What the session starts of other packages, as it was found in their branches `master` and, where it is named, `devel`.
FILES_OF_MRS = {
    "mrs_uav_gazebo_simulation": {"launch/simulation.launch", "config/mrs_uav_system/x500.yaml"},
    "mrs_uav_status": {"launch/status.launch"}, "mrs_uav_px4_api": {"launch/api.launch"},
    "mrs_uav_core": {"launch/core.launch"}, "mrs_uav_autostart": {"launch/automatic_start.launch"},
    "mrs_rviz_plugins": {"launch/load_robot.launch"}}
SESSION = os.path.join(ROOT, "tmux", "forest")


def session_commands():
    with open(os.path.join(SESSION, "session.yml")) as source:
        session = yaml.safe_load(source)
    exported = dict(re.findall(r"export (\w+)=(\w+)", session["pre_window"]))
    panes = [pane for window in session["windows"] for part in window.values() for pane in part["panes"]]
    return exported, panes


def test_every_file_that_the_tmux_session_names_exists(monkeypatch):
    exported, panes = session_commands()
    text = "\n".join(panes).replace("$UAV_TYPE", exported["UAV_TYPE"])
    own = re.findall(r"\./([\w./]+)", text)
    assert len(own) >= 5
    for path in own:
        assert os.path.isfile(os.path.join(SESSION, path)), path
    named = [(package, "launch/" + name) for package, name in re.findall(r"roslaunch (\w+) (\w+\.launch)", text)]
    named += re.findall(r"`rospack find (\w+)`/([\w./]+)", text)
    assert {package for package, _ in named} == set(FILES_OF_MRS) | {"voxnav"}
    for package, path in named:
        assert os.path.isfile(os.path.join(ROOT, path)) if package == "voxnav" else path in FILES_OF_MRS[package]


def test_the_tmux_session_starts_voxnav_with_arguments_that_it_has(monkeypatch):
    exported, panes = session_commands()
    for name, value in exported.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("PWD", SESSION)
    monkeypatch.setitem(ARGUMENTS, "voxnav", [])
    monkeypatch.setitem(ARGUMENTS, "rviz", [])
    started = [re.search(r"roslaunch voxnav (\w+)\.launch(.*)", pane) for pane in panes if "roslaunch voxnav" in pane]
    assert [command.group(1) for command in started] == ["voxnav", "rviz"]
    for command in started:
        config = loaded(command.group(1), *command.group(2).split())
        assert config.nodes and not config.config_errors
        for argument in command.group(2).split():
            assert 'name="%s"' % argument.split(":=")[0] in open(
                os.path.join(ROOT, "launch", command.group(1) + ".launch")).read()
