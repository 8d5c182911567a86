# SPDX-License-Identifier: BSD-3-Clause
"""Every script runs as a command: the short ones here, on little data, and the others in the test that RUN_BY names."""

import json
import os
import re
import shutil
import sys

import numpy as np
import pytest
from running import run_command

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# Scripts that other tests run, and those that build something, which the commands of the Makefile run.
RUN_BY = {
    "bumper": "launch/octomap_face.launch",
    "campaign": "test/python/test_campaign.py",
    "demo": "test/python/test_lockstep.py",
    "demo_two_uavs": "test/rostest/two_uavs.test",
    "demo_real": "test/python/test_demo_real.py",
    "laser_scan_cloud": "launch/octomap_face.launch",
    "livox_cloud": "test/rostest/recording_nodes.test",
    "octomap_config": "launch/mapplan.launch",
    "octomap_planner": "launch/octomap_face.launch",
    "octomap_server": "launch/octomap_face.launch",
    "planning_manager": "test/rostest/planning_manager.test",
    "recording_mount": "test/rostest/recording_nodes_test.py",
    "rviz_view": "test/python/test_rviz_view.py",
    "submap_optimizer": "test/rostest/submap_optimizer.test",
    "dev/build_deb": "Makefile",
    "dev/build_workspace": "Makefile",
    "dev/in_workspace": "test/python/test_in_workspace.py",
    "dev/install_deps": "Makefile",
    "dev/progress": "Makefile",
    "dev/run_benchmarks": "Makefile",
    "dev/run_docs": "Makefile",
    "dev/run_install_tests": "Makefile",
    "dev/run_lint": "Makefile",
    "dev/run_sanitizers": "Makefile",
    "dev/run_tests": "Makefile",
    "dev/run_tidy": "Makefile",
}
RUN_HERE = {"check_recording", "map_bag", "merge_maps", "evaluate_alignment", "evaluate_foliage", "evaluate_ghosts",
            "evaluate_rain", "evaluate_reaction", "dev/make_parameter_docs", "dev/make_stubs", "dev/plot_local_map",
            "dev/plot_sensors"}


def run(script, *arguments, status=0):
    """Runs a script and returns what it printed."""
    command = [sys.executable, os.path.join(ROOT, "scripts", script)] + [str(word) for word in arguments]
    done = run_command(command, cwd=ROOT)
    assert done.returncode == status, "%s %s: %s" % (script, arguments, done.stdout)
    return done.stdout


def rows_of(table):
    """Returns the rows of numbers and words of a table in Markdown, without its header."""
    lines = [line for line in table.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def is_picture(path):
    with open(str(path), "rb") as source:
        return source.read(8) == b"\x89PNG\r\n\x1a\n" and os.path.getsize(str(path)) > 10000


def test_every_script_is_run_by_a_test():
    folder = os.path.join(ROOT, "scripts")
    scripts = {os.path.relpath(os.path.join(at, name), folder) for at, _, names in os.walk(folder) for name in names
               if os.access(os.path.join(at, name), os.X_OK) and not at.endswith("__pycache__")}
    assert scripts == RUN_HERE | set(RUN_BY)


@pytest.mark.parametrize("script", sorted(RUN_BY))
def test_what_runs_a_script_names_it(script):
    with open(os.path.join(ROOT, RUN_BY[script])) as source:
        assert re.search(r"\b%s\b" % os.path.basename(script), source.read())


@pytest.mark.parametrize("script,made", [("make_stubs", "src/voxnav/_core.pyi"),
                                         ("make_parameter_docs", "docs/parameters.md")])
def test_files_are_made_as_they_are_in_the_repository(script, made, tmp_path):
    pytest.importorskip("voxnav._simulation")
    # The scripts write beside themselves, so that a copy of them leaves the checkout as it is.
    for folder in ("scripts/dev", os.path.dirname(made)):
        (tmp_path / folder).mkdir(parents=True)
    shutil.copy(os.path.join(ROOT, "scripts", "dev", script), str(tmp_path / "scripts" / "dev"))
    run(str(tmp_path / "scripts" / "dev" / script))
    with open(os.path.join(ROOT, made)) as expected:
        assert (tmp_path / made).read_text() == expected.read()


def test_a_recording_is_checked_and_mapped_and_its_map_merged_with_another(tmp_path):
    pytest.importorskip("voxnav.simulation")
    pytest.importorskip("rosbag")
    from recordings import flight, sweeps, write_messages

    bag = write_messages(str(tmp_path / "flight.bag"), flight(sweeps(num_scans=6)[1]))
    assert "problems     none" in run("check_recording", bag)
    said = run("map_bag", bag, "--out", tmp_path / "out")
    assert "left out: nothing" in said and "6 of 6 scans were mapped" in said
    for name in ("trajectory.txt", "trajectory_odom.txt", "occupied.ply", "obstacles.ply", "mesh.ply", "map.ot",
                 "report.html", "metrics.json"):
        assert os.path.getsize(str(tmp_path / "out" / name)) > 0, name
    maps = [tmp_path / "out" / "map"] * 2
    assert "2 submaps in" in run("merge_maps", *maps, tmp_path / "merged", "--pose", 30, 0, 0, 0.5)
    assert "no such file" in run("check_recording", tmp_path / "nothing.bag", status=1)
    assert "merge_maps: " in run("merge_maps", tmp_path / "nothing", maps[0], tmp_path / "none", status=1)


def test_foliage_is_evaluated():
    pytest.importorskip("voxnav._simulation")
    rows = rows_of(run("evaluate_foliage", "--seeds", 4, "--scans", 6, "--columns", 128))
    assert {row[1] for row in rows} == {"0.2", "0.4"} and {"all", "leaves", "occupied"} <= {row[2] for row in rows}
    assert all(0.5 < float(row[4]) <= 1.0 for row in rows if row[2] == "all")


def test_rain_is_evaluated():
    pytest.importorskip("voxnav._simulation")
    rows = rows_of(run("evaluate_rain", "--seeds", 4, "--scans", 5, "--rain", 25))
    false_per_minute = {(row[2], row[3]): float(row[4]) for row in rows}
    for resolution in ("0.2", "0.4"):
        assert false_per_minute[resolution, "True"] < 0.2 * false_per_minute[resolution, "False"]
    assert all(re.match(r"0\.\d+ / 0\.\d+$|1\.000 / 0\.\d+$", cell) for row in rows for cell in row[6:])


def test_the_reaction_to_a_truck_is_evaluated():
    rows = rows_of(run("evaluate_reaction", "--gaps", 8, 4, "--speeds", 3))
    assert [row[:3] for row in rows] == [["8.0", "3.0", "1"], ["4.0", "3.0", "1"]]
    assert all(float(row[3]) > min(1.1, float(row[4])) - 0.05 for row in rows)


def test_alignment_and_ghosts_are_evaluated(tmp_path):
    pytest.importorskip("matplotlib")
    pytest.importorskip("voxnav._simulation")
    said = run("evaluate_alignment", "--scenarios", "corridor", "--seeds", 1, "--scan-hz", 1, "--out", tmp_path)
    assert re.search(r"corridor +seed 1: [\d.]+ -> [\d.]+ m", said) and is_picture(tmp_path / "corridor_1.png")
    results = json.loads((tmp_path / "alignment.json").read_text())
    assert [r["scenario"] for r in results] == ["corridor"] and results[0]["submaps"] > 3
    said = run("evaluate_ghosts", "--seeds", 1, "--scan-hz", 0.5, "--out", tmp_path)
    assert re.search(r"1  corrected +[\d.]+ %", said) and is_picture(tmp_path / "truck_1.png")


def test_a_map_of_three_sensors_is_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    pytest.importorskip("voxnav._simulation")
    run("dev/plot_sensors", tmp_path / "sensors.png", "--scans", 3)
    assert is_picture(tmp_path / "sensors.png")


def test_poles_and_twigs_are_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    random = np.random.RandomState(1)
    truth = np.column_stack([random.uniform(0.0, 3.0, (2000, 3)), random.randint(0, 8, 2000)])
    truth.astype(np.float32).tofile(str(tmp_path / "truth.f32"))
    truth[:, :3].astype(np.float32).tofile(str(tmp_path / "voxnav.f32"))
    run("dev/plot_local_map", tmp_path, tmp_path / "poles.png")
    assert is_picture(tmp_path / "poles.png")
