# SPDX-License-Identifier: BSD-3-Clause
"""Only the time seam knows whether time is real or simulated in lock-step; flight code does not depend on it."""

import os
import re

from test_floors import ROOT, git_files

WORDS = re.compile(r"lock[-_ ]?step|is_synchronous", re.IGNORECASE)
# The files that may mention lock-step: the seam, the simulator with its configuration, the programs that start and lead
# a simulation, and texts about it.
ALLOWED = re.compile(
    r"^(include/voxnav_ros/time_seam\.hpp|src/ros/time_seam\.cpp|src/voxnav/nodes/time_seam\.py"
    r"|src/simulation/|src/ros/uav_simulator/|include/voxnav_simulation/|config/uav_simulator\.yaml"
    r"|launch/|src/voxnav/demo/|src/voxnav/campaign/|src/voxnav/nodes/(demo_mission|flight_recorder|time_leader)\.py"
    r"|test/|docs/|README\.md|CHANGELOG\.rst|CONTRIBUTING\.md|scripts/dev/)")


def test_flight_code_does_not_depend_on_the_kind_of_time():
    found = []
    for path in git_files("*"):
        if ALLOWED.match(path):
            continue
        with open(os.path.join(ROOT, path), errors="ignore") as source:
            found += ["%s:%d: %s" % (path, number, line.strip()) for number, line in enumerate(source, 1)
                      if WORDS.search(line)]
    assert not found, "\n".join(found)


def test_the_lag_of_the_simulation_is_the_sweep_of_the_seam():
    with open(os.path.join(ROOT, "launch/simulation.launch")) as launch:
        lag_s = re.search(r'name="node/lockstep_lag_s" value="([0-9.]+)"', launch.read()).group(1)
    with open(os.path.join(ROOT, "src/voxnav/nodes/time_seam.py")) as seam:
        sweep_s = re.search(r"^SWEEP_S = ([0-9.]+)$", seam.read(), re.MULTILINE).group(1)
    assert float(lag_s) == float(sweep_s)
