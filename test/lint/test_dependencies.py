# SPDX-License-Identifier: BSD-3-Clause
"""package.xml declares what the sources include, import, launch, run and find with CMake, and nothing else.

Dependencies are compared by kind: what only tests use must not be needed to fly, and what only people on the ground
need is a dependency only where VOXNAV_GROUND_STATION is 1.
"""

import importlib.util
import os
import re
import sysconfig
from xml.etree import ElementTree

import pytest

from test_floors import ROOT, git_files

# The packages whose names differ from those of their headers, Python modules, CMake packages or programs.
HEADERS = {"Eigen": "eigen", "ceres": "libceres-dev", "octomap": "liboctomap-dev", "embree3": "libembree-dev",
           "pcl": "libpcl-all-dev", "pybind11": "pybind11-dev", "ros": "roscpp", "yaml-cpp": "yaml-cpp"}
MODULES = {"numpy": "python3-numpy", "yaml": "python3-yaml", "scipy": "python3-scipy", "pytest": "python3-pytest",
           "matplotlib": "python3-matplotlib", "rospkg": "python3-rospkg", "setuptools": "python3-setuptools",
           "catkin_pkg": "catkin", "pyproj": "python3-pyproj"}
CMAKE_PACKAGES = {"Ceres": "libceres-dev", "Eigen3": "eigen", "GTest": "gtest", "Python3": "python3-dev",
                  "embree": "libembree-dev", "octomap": "liboctomap-dev", "pybind11": "pybind11-dev"}
PROGRAMS = {"Xvfb": "xvfb", "import": "imagemagick", "pointcloud_to_pcd": "pcl_ros", "rviz": "rviz",
            "roslaunch": "roslaunch", "rosnode": "rosnode"}
GROUND = {"rviz", "xvfb", "imagemagick", "python3-matplotlib", "python3-scipy"}
# Rosdep has no keys for these modules, so package.xml cannot declare them; they are in the lists of Debian packages.
UNKNOWN_TO_ROSDEP = {"distributed": "python3-distributed", "optuna": "python3-optuna"}
# Names that are not packages, because they belong to the C library, the compiler or voxnav.
NOT_PACKAGES = {"sys", "voxnav", "voxnav_ros", "voxnav_simulation", "Threads"}
GENERATED_MESSAGES = {"build": {"message_generation"}, "exec": {"message_runtime"}, "build_export": {"message_runtime"}}
# Benchmarks are left out, because they are not installed.
BENCHMARKS = "test/benchmark/"

KINDS = {"depend": ("build", "build_export", "exec"), "build_depend": ("build",),
         "build_export_depend": ("build_export",), "exec_depend": ("exec",), "test_depend": ("test",),
         "buildtool_depend": ("build",)}


def declared():
    """Returns {kind: names}, in which the kind "ground" holds the packages under the condition for ground stations."""
    found = {"build": set(), "build_export": set(), "exec": set(), "test": set(), "ground": set()}
    for element in ElementTree.parse(os.path.join(ROOT, "package.xml")).getroot():
        if element.tag not in KINDS:
            continue
        condition = element.get("condition")
        assert condition in (None, "$VOXNAV_GROUND_STATION == 1"), condition
        for kind in KINDS[element.tag] if condition is None else ("ground",):
            found[kind].add(element.text)
    return found


def matches(pattern, *files):
    """Returns {text that the pattern finds: a file that holds it}."""
    found = {}
    for path in git_files(*files):
        if path.startswith(BENCHMARKS) or path.startswith("interfaces/"):
            continue
        with open(os.path.join(ROOT, path), encoding="utf-8") as source:
            found.update((match, path) for match in re.findall(pattern, source.read(), re.MULTILINE))
    return found


def headers(*files):
    found = matches(r'^\s*#\s*include <([\w+-]+)/', *files)
    return {HEADERS.get(name, name): path for name, path in found.items()
            if name not in NOT_PACKAGES and name != "gtest"}


def is_of_the_standard_library(module):
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin in (None, "built-in", "frozen"):
        return spec is not None and spec.origin is not None
    paths = sysconfig.get_paths()
    return spec.origin.startswith((paths["stdlib"], paths["platstdlib"])) and "-packages" not in spec.origin


def modules(*files):
    own = {os.path.splitext(os.path.basename(path))[0] for path in git_files("test/*.py")} | NOT_PACKAGES
    found = matches(r'^\s*(?:import|from) (\w+)', *files)
    found.update(matches(r'importorskip\("(\w+)"', *files))
    return {MODULES.get(name, name): path for name, path in found.items()
            if name not in own and name not in UNKNOWN_TO_ROSDEP and not is_of_the_standard_library(name)}


def launched(folder):
    found = matches(r'pkg="(\w+)"', folder + "/*.launch", folder + "/*.test")
    return {name: path for name, path in found.items() if name != "voxnav"}


def programs(*files):
    found = matches(r'(?:which\(|\[)"(\w+)"', *files)
    return {PROGRAMS[name]: path for name, path in found.items() if name in PROGRAMS}


def used_to_build():
    return dict(headers("include/*.hpp", "src/*.hpp", "src/*.cpp"), **modules("setup.py"))


def used_to_fly():
    own_programs = [path for path in git_files("scripts") if not path.startswith("scripts/dev/")]
    return {**modules("src/*.py", *own_programs), **launched("launch"), **programs("src/*.py")}


def used_to_test():
    return {**modules("test/python/*.py", "test/rostest/*.py", "test/lint/*.py"),
            **headers("test/unit/*.cpp", "test/property/*.cpp", "test/support/*.hpp"),
            **launched("test"), **programs("test/*.py")}


def missing(used, names):
    return ["%s (%s)" % item for item in sorted(used.items()) if item[0] not in names]


def test_what_the_sources_include_is_a_build_dependency():
    assert not missing(used_to_build(), declared()["build"])


def test_what_public_headers_include_is_exported():
    assert not missing(headers("include/voxnav/*.hpp"), declared()["build_export"])


def test_what_runs_is_an_exec_dependency_or_one_of_the_ground_station():
    kinds = declared()
    assert not missing(used_to_fly(), kinds["exec"] | kinds["ground"])


def test_packages_of_the_ground_station_are_not_dependencies_of_the_aircraft():
    kinds = declared()
    assert kinds["ground"] == GROUND
    assert not kinds["exec"] & GROUND


@pytest.mark.parametrize("module", sorted(UNKNOWN_TO_ROSDEP))
def test_what_rosdep_does_not_know_is_a_package_of_the_list_and_is_used(module):
    with open(os.path.join(ROOT, "scripts", "dev", "packages-debian.txt")) as source:
        assert UNKNOWN_TO_ROSDEP[module] in source.read().split()
    assert module in matches(r"^\s*(?:import|from) (\w+)", "src/*.py")


def test_what_the_tests_use_is_a_test_dependency():
    kinds = declared()
    assert not missing(used_to_test(), kinds["test"] | kinds["exec"] | kinds["build"])


def test_what_cmake_finds_is_declared():
    found = matches(r'find_package\(([\w-]+)', "CMakeLists.txt", "cmake/*.cmake", "src/*CMakeLists.txt",
                    "test/CMakeLists.txt")
    found = {CMAKE_PACKAGES.get(name, name): path for name, path in found.items() if name not in NOT_PACKAGES}
    components = re.search(r"find_package\(catkin REQUIRED COMPONENTS([^)]*)\)",
                           open(os.path.join(ROOT, "cmake", "catkin.cmake")).read()).group(1)
    found.update((name, "cmake/catkin.cmake") for name in components.split())
    kinds = declared()
    assert not missing(found, kinds["build"] | kinds["test"])


def test_nothing_is_declared_that_is_not_used():
    kinds = declared()
    in_messages = set(matches(r'^(\w+)/\w+ ', "msg/*.msg", "srv/*.srv"))
    build = set(used_to_build()) | in_messages | GENERATED_MESSAGES["build"] | {"catkin", "python3-dev", "rospy"}
    fly = build | set(used_to_fly()) | GENERATED_MESSAGES["exec"]
    assert not sorted(kinds["build"] - build)
    assert not sorted((kinds["exec"] | kinds["ground"]) - fly)
    # Tests draw pictures, so the packages of the ground station may be test dependencies as well.
    assert not sorted(kinds["test"] - set(used_to_test()) - GROUND - {"gtest"})
