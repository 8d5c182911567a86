# SPDX-License-Identifier: BSD-3-Clause
"""Shipped configurations and docs/parameters.md agree with the defaults in the code."""

import os

import pytest
import yaml

from voxnav import parameters

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# These files list only the parameters that differ from the defaults.
PARTIAL = {"faults", "map_bag", "simulation", "thesis"}


@pytest.fixture(scope="module")
def everything():
    program = parameters.describing_program()
    if program is None:
        pytest.skip("describe_parameters is not built: no ROS workspace")
    return dict(parameters.nodelet_parameters(program), **parameters.python_parameters())


def configurations():
    return sorted(name[:-5] for name in os.listdir(os.path.join(ROOT, "config")) if name.endswith(".yaml"))


def load(name):
    with open(os.path.join(ROOT, "config", name + ".yaml")) as source:
        return yaml.safe_load(source)


@pytest.mark.parametrize("node", [name for name in configurations() if name not in PARTIAL])
def test_shipped_configurations_are_the_defaults(everything, node):
    tree = load(node)
    assert set(tree) == set(everything[node])
    for section, fields in everything[node].items():
        names = [field["name"] for field in fields]
        assert list(tree[section]) == names, "%s/%s: same fields in the same order" % (node, section)
        for field in fields:
            assert tree[section][field["name"]] == field["default"], "%s/%s/%s" % (node, section, field["name"])


@pytest.mark.parametrize("name", sorted(PARTIAL & set(configurations())))
def test_partial_configurations_name_existing_parameters(everything, name):
    tree = {name: load(name)} if name in everything else load(name)
    for node, sections in tree.items():
        assert_known(everything, node, sections, name)


def assert_known(everything, node, sections, name):
    """The filters of further sensors are called like the first, with the name of the sensor."""
    kind = "cloud_filter" if node.startswith("cloud_filter_") else node
    for section, values in sections.items():
        known = {field["name"] for field in everything[kind][section]}
        assert set(values) <= known, "%s: %s/%s" % (name, node, section)


def test_configurations_of_sensors_name_existing_parameters(everything):
    limits = load("sensors/depth_camera")
    assert set(limits) == {field["name"] for field in everything["local_mapper"]["lidar"]}
    assert_known(everything, "lidar_simulator", load("sensors/simulated_tilted_lidar"), "simulated_tilted_lidar")


def test_every_node_has_a_configuration(everything):
    assert set(everything) <= set(configurations())


def test_the_page_begins_with_twenty_parameters_that_exist(everything):
    first = parameters.markdown(everything).split("\n## ")[1]
    assert first.startswith("What people change") and first.count("\n| `") == len(parameters.OFTEN_CHANGED) == 20


def test_documentation_is_up_to_date(everything):
    with open(os.path.join(ROOT, "docs", "parameters.md")) as source:
        assert source.read() == parameters.markdown(everything), "run scripts/dev/make_parameter_docs"
