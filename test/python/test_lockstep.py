# SPDX-License-Identifier: BSD-3-Clause
"""A flight in lock-step does not depend on the machine: it is the same to the last bit on an idle and a loaded one."""

import contextlib
import json
import os
import subprocess
import sys

import pytest
from running import run_command

rospkg = pytest.importorskip("rospkg")
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# The figures of a summary that may depend on the machine.
OF_THE_MACHINE = ("stages", "rss_mb", "real_time_factor", "fell_behind")


@contextlib.contextmanager
def load(num_processes):
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(num_processes)]
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


def fly(out):
    """Flies through the grove, and returns the figures of its summary and the bytes of its map."""
    command = [os.path.join(ROOT, "scripts", "demo"), "--world", "grove", "--lockstep", "--speed", "0", "--no-rviz",
               "--out", str(out)]
    run = run_command(command)
    assert run.returncode == 0, run.stdout[-3000:]
    with open(str(out / "summary.json")) as source:
        summary = json.load(source)
    return {key: value for key, value in summary.items() if key not in OF_THE_MACHINE}


@pytest.mark.parametrize("is_leader", [False, True])
def test_a_mission_that_finds_no_master_ends_with_a_reason(monkeypatch, is_leader):
    mission = pytest.importorskip("voxnav.nodes.demo_mission")

    def wait_in_vain(uri, timeout_s):
        raise mission.MissionError("no ROS master at " + uri)

    class Record:
        reason = ""

    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:1")
    monkeypatch.setattr(mission, "wait_for_master", wait_in_vain)
    mission.fly(Record, (1.0, 0.0, 2.0), "", is_leader=is_leader)
    assert Record.reason == "no ROS master at http://127.0.0.1:1"


def test_flights_are_the_same_on_an_idle_and_on_a_loaded_machine(tmp_path):
    try:
        rospkg.RosPack().get_path("voxnav")
    except rospkg.ResourceNotFound:
        pytest.skip("voxnav is not in a catkin workspace")
    first = fly(tmp_path / "idle")
    with load(3):
        second = fly(tmp_path / "loaded")
    assert first["reached"]
    assert first == second
