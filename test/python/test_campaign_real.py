# SPDX-License-Identifier: BSD-3-Clause
"""A campaign of two flights in the simulator, side by side, at two speed limits."""

import csv
import os

import pytest
from running import run_command

rospkg = pytest.importorskip("rospkg")
pytest.importorskip("distributed")
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SPEEDS_MPS = (1.5, 4.0)


def test_two_flights_side_by_side(tmp_path):
    try:
        rospkg.RosPack().get_path("voxnav")
    except rospkg.ResourceNotFound:
        pytest.skip("voxnav is not in a catkin workspace")
    command = [os.path.join(ROOT, "scripts", "campaign"), "--worlds", "grove", "--seeds", "1", "--densities", "100",
               "--speeds", "%g,%g" % SPEEDS_MPS, "--workers", "2", "--config",
               os.path.join(ROOT, "test", "support", "light_sensor.yaml"), "--out", str(tmp_path)]
    run = run_command(command)
    assert run.returncode == 0, run.stdout[-3000:]
    with open(str(tmp_path / "flights.csv"), newline="") as source:
        rows = sorted(csv.DictReader(source), key=lambda row: float(row["speed_mps"]))
    assert [float(row["speed_mps"]) for row in rows] == list(SPEEDS_MPS)
    for row in rows:
        assert row["reached"] == "true" and row["collided"] == "false" and float(row["min_clearance_m"]) > 0.5
        assert 0.3 < float(row["mean_speed_mps"]) < float(row["speed_mps"])
        assert 1.0 <= float(row["path_ratio"]) < 1.6
        assert row["hovers"] != "" and row["shortened"] != ""
    assert float(rows[0]["mean_speed_mps"]) < float(rows[1]["mean_speed_mps"])
