# SPDX-License-Identifier: BSD-3-Clause
"""Flight code does not depend on how time runs, marks absence by no special number, and calls nothing by text."""

import os
import re

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# Flight code is what these folders hold; the simulator, launch files and tests are not part of it.
FOLDERS = ("include/voxnav", "include/voxnav_ros", "src/core", "src/bindings", "src/ros", "src/voxnav")
SUFFIXES = (".hpp", ".cpp", ".py")
# The files in these folders that may know how time runs: the seam with its parameters, the programs that drive a
# simulation (its leader, the demonstrations and campaigns), and the simulator's nodelet.
MAY_KNOW_HOW_TIME_RUNS = (
    "include/voxnav/pipeline/time_config.hpp", "include/voxnav_ros/time_seam.hpp", "src/ros/time_seam.cpp",
    "src/voxnav/nodes/time_seam.py", "src/voxnav/nodes/time_leader.py", "src/voxnav/demo/flight.py",
    "src/voxnav/demo/two_uavs.py", "src/voxnav/demo/recording.py", "src/voxnav/campaign/flight.py",
    "src/ros/uav_simulator/")


def flight_code():
    """Yields (path, text) of every file of FOLDERS."""
    for folder in FOLDERS:
        for here, _, names in os.walk(os.path.join(ROOT, folder)):
            for name in names:
                if name.endswith(SUFFIXES):
                    path = os.path.join(here, name)
                    with open(path) as source:
                        yield os.path.relpath(path, ROOT), source.read()


def places(pattern, allowed=()):
    """Returns the lines of flight code that match, as path:line, without those below the allowed paths."""
    return ["%s:%d" % (path, text[:match.start()].count("\n") + 1) for path, text in flight_code()
            if not path.startswith(allowed) for match in re.finditer(pattern, text)]


def test_only_the_seam_knows_whether_a_simulation_waits():
    assert places(r"lockstep|is_synchronous|waits_for_simulation", MAY_KNOW_HOW_TIME_RUNS) == []


def test_no_special_number_stands_for_absence():
    assert places(r"\b1e1[78]\b") == []


@pytest.mark.parametrize("pattern", [r"getattr\(self, \"_?[a-z]+_\" \+"])
def test_no_method_is_called_by_a_computed_name(pattern):
    assert places(pattern) == []
