# SPDX-License-Identifier: BSD-3-Clause
"""A file of the core includes only from its own floor or a lower one, and never from ROS."""

import os
import re
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# The height of each floor; see docs/architecture.md.
FLOORS = {
    "base": 0, "geometry": 1, "kernels": 2, "containers": 3, "cloud": 4, "occupancy": 5, "submap": 6, "odometry": 6,
    "graph": 6, "planning": 7, "pipeline": 8,
}
# Pairs (from, to) of floors that may not include each other although the heights allow it: the graph sees submaps only
# as DistanceField and planning sees maps only as OccupancyView.
FORBIDDEN = {("graph", "submap"), ("submap", "graph"), ("planning", "occupancy"), ("planning", "submap"),
             ("planning", "graph"), ("planning", "odometry"), ("odometry", "submap"), ("odometry", "graph"),
             ("submap", "odometry"), ("graph", "odometry"), ("graph", "occupancy"), ("odometry", "occupancy")}
# Words of vector code, which may stand on the floor kernels only.
VECTOR_CODE = re.compile(r'(\b_mm\d*_\w+|__m(?:128|256|512)\w*|vector_size|__builtin_shuffle\w*|immintrin|arm_neon'
                         r'|\bVOXNAV_WIDE\b|target\(")')
ROS_HEADER = re.compile(r'#include\s+[<"](ros|nodelet|tf2|tf2_ros|pluginlib|rosbag|\w+_msgs|voxnav_ros)/')
OWN_HEADER = re.compile(r'#include\s+"(?:voxnav/)?(%s)/' % "|".join(FLOORS))


def git_files(*patterns):
    out = subprocess.check_output(["git", "ls-files"] + list(patterns), cwd=ROOT, universal_newlines=True)
    return [name for name in out.splitlines() if os.path.exists(os.path.join(ROOT, name))]


def core_files():
    return git_files("include/voxnav/*.hpp", "src/core/*.hpp", "src/core/*.cpp")


def floor_of(path):
    parts = path.split("/")
    return parts[2]


def includes(path, pattern):
    with open(os.path.join(ROOT, path)) as source:
        return [match for line in source for match in pattern.findall(line)]


def test_there_are_core_files():
    assert len(core_files()) > 10


def test_no_file_includes_from_a_higher_floor():
    broken = []
    for path in core_files():
        floor = floor_of(path)
        for used in includes(path, OWN_HEADER):
            if FLOORS[used] > FLOORS[floor] or (floor, used) in FORBIDDEN:
                broken.append("%s (floor %s) includes from %s" % (path, floor, used))
    assert not broken, "\n".join(broken)


def test_the_core_includes_nothing_of_ros():
    broken = [path for path in core_files() if includes(path, ROS_HEADER)]
    assert not broken, broken


def test_vector_code_lies_on_the_floor_kernels():
    sources = git_files("include/*.hpp", "src/*.hpp", "src/*.cpp")
    assert any(includes(path, VECTOR_CODE) for path in sources), "the pattern finds nothing"
    broken = [path for path in sources if not path.startswith("src/core/kernels/") and includes(path, VECTOR_CODE)]
    assert not broken, broken


def test_only_the_nodes_import_rospy():
    broken = []
    for path in git_files("src/voxnav/*.py"):
        if not path.startswith("src/voxnav/nodes/"):
            broken += [path] * len(includes(path, re.compile(r"^\s*(?:import|from)\s+(rospy)\b")))
    assert not broken, broken


def test_every_source_names_its_licence():
    broken = []
    for path in git_files("*.hpp", "*.cpp", "src/voxnav/*.py"):
        with open(os.path.join(ROOT, path)) as source:
            if "SPDX-License-Identifier: BSD-3-Clause" not in source.readline():
                broken.append(path)
    assert not broken, broken
