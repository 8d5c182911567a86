# SPDX-License-Identifier: BSD-3-Clause
"""Point times of any driver give as good a map as those of Ouster, or a warning says why they are not used."""

import json

import numpy as np
import pytest

import voxnav
from voxnav.offline.cli import main

pytest.importorskip("voxnav.simulation")
pytest.importorskip("rosbag")

from recordings import SWEEP_S, TimeField, sweeps, write_bag  # noqa: E402

FIRST_STAMP_S = 1700000000.0
BOOT_S = FIRST_STAMP_S - 5000.0
DRIVERS = {
    "velodyne, stamped at the end": TimeField("time", "<f4", lambda o, t: o - SWEEP_S, SWEEP_S),
    "robosense, stamped at the end": TimeField("timestamp", "<f8", lambda o, t: o + t, SWEEP_S),
    "livox": TimeField("timestamp", "<f8", lambda o, t: (o + t) * 1e9),
    "milliseconds": TimeField("time", "<f4", lambda o, t: o * 1e3),
    "microseconds": TimeField("time", "<f4", lambda o, t: o * 1e6),
    "seconds as float64": TimeField("timestamp", "<f8", lambda o, t: o),
    "nanoseconds as float64": TimeField("time", "<f8", lambda o, t: o * 1e9),
    "a clock of the sensor, seconds": TimeField("timestamp", "<f8", lambda o, t: o + t - BOOT_S),
    "a clock of the sensor, 32 bits": TimeField("t", "<u4", lambda o, t: (o + t - BOOT_S) * 1e9),
    "before the stamp, unsigned": TimeField("t", "<u4", lambda o, t: (o - SWEEP_S) * 1e9, SWEEP_S),
}
UNREADABLE = {
    "steps of 10 us": TimeField("time", "<u4", lambda o, t: o * 1e5),
    "always the same": TimeField("timestamp", "<f4", lambda o, t: 0.0 * o + t),
}


@pytest.fixture(scope="module")
def scans():
    return sweeps(num_scans=12)


@pytest.fixture(scope="module")
def mapped(scans, tmp_path_factory):
    """Returns a function that maps scans with given times, and returns the share of the map on the true surface and
    the warnings."""

    def run(times):
        folder = tmp_path_factory.mktemp("times")
        write_bag(str(folder / "flight.bag"), scans[1], first_stamp_s=FIRST_STAMP_S, times=times)
        (folder / "fine.yaml").write_text("map: {resolution_m: 0.2}\nrun: {write_mesh: false}\n")
        out = folder / "out"
        assert main([str(folder / "flight.bag"), "--config", str(folder / "fine.yaml"), "--out", str(out)]) == 0
        points = voxnav.SubmapCollection.load(str(out / "map")).occupied_points().astype(np.float64)
        warnings = json.loads((out / "metrics.json").read_text())["warnings"]
        return np.mean(scans[0].surface_distance(points) < 0.1), warnings

    return run


@pytest.fixture(scope="module")
def with_times(mapped):
    share, warnings = mapped(TimeField())
    assert warnings == []
    return share


@pytest.fixture(scope="module")
def without_times(mapped, with_times):
    share, warnings = mapped(TimeField(""))
    assert warnings == []
    assert share < with_times - 0.05  # the share would not tell the difference if it were smaller
    return share


@pytest.mark.parametrize("driver", sorted(DRIVERS))
def test_times_of_any_driver_give_the_same_map(driver, mapped, with_times):
    share, warnings = mapped(DRIVERS[driver])
    assert warnings == []
    assert share > with_times - 0.01


@pytest.mark.parametrize("driver", sorted(UNREADABLE))
def test_times_that_cannot_be_read_are_not_used_and_named(driver, mapped, without_times):
    share, warnings = mapped(UNREADABLE[driver])
    assert share > without_times - 0.01
    assert len(warnings) == 1
    assert "12 of 12 clouds are used without point times" in warnings[0] and UNREADABLE[driver].name in warnings[0]
