# SPDX-License-Identifier: BSD-3-Clause
"""The summary of a flight holds what was measured, and states it when something was not measured."""

import json
import threading

import numpy as np
import pytest

from voxnav.demo import summary
from voxnav.demo.record import FlightRecord, Track

FIELDS = {"reached", "reason", "min_clearance_m", "path_length_m", "straight_m", "flight_s", "real_time_factor",
          "ate_odometry_m", "ate_optimised_m", "stages", "rss_mb"}


def flown_record():
    """Returns the record of a flight straight ahead at 2 m/s for 10 s after 2 s at rest, with odometry that drifts."""
    record = FlightRecord("forest", 3)
    for t in np.arange(0.0, 12.0, 0.1):
        x = max(0.0, 2.0 * (t - 2.0))
        record.truth_track.add(t, (x, np.sin(x), 2.0))
        record.odometry_track.add(t, (x, np.sin(x) + 0.02 * x * x, 2.0))
    record.optimised = record.truth
    record.mission = (2.0, 11.9)
    record.reached, record.reason, record.min_clearance_m, record.real_time_factor = True, "goal reached", 1.2, 0.999
    return record


def test_figures_of_a_known_flight():
    result = summary.summarise(flown_record())
    assert FIELDS <= set(result)
    assert result["straight_m"] == pytest.approx(np.hypot(19.8, np.sin(19.8)), abs=0.01)
    assert result["path_length_m"] > result["straight_m"]
    assert result["flight_s"] == pytest.approx(9.9)
    assert result["ate_optimised_m"] < 1e-6 < 0.05 < result["ate_odometry_m"]
    assert result["fell_behind"] == []
    assert "fell behind             nothing" in summary.table(result)


def test_figures_that_were_not_measured_are_absent(tmp_path):
    result = summary.summarise(FlightRecord("forest", 1))
    for name in ("min_clearance_m", "straight_m", "flight_s", "real_time_factor", "ate_odometry_m", "ate_optimised_m"):
        assert result[name] is None
    assert result["reached"] is False
    assert summary.table(result).count("not measured") >= 4
    summary.write_json(str(tmp_path / "summary.json"), result)
    assert json.loads((tmp_path / "summary.json").read_text())["min_clearance_m"] is None


def test_stages_that_fell_behind_are_named():
    record = flown_record()
    record.real_time_factor = 0.8
    record.dropped_in_flight = {"local_mapper/insert": 3, "cloud_filter/filter": 0}
    assert summary.fell_behind(record) == ["the simulation itself (factor 0.80)", "local_mapper/insert dropped 3"]
    record.speed_factor = 0.8  # the simulation is configured to be this slow
    assert summary.fell_behind(record) == ["local_mapper/insert dropped 3"]


def test_tracks_can_be_read_while_they_grow():
    track, stop = Track(), threading.Event()

    def grow():
        t = 0.0
        while not stop.is_set() and t < 20000.0:
            t += 1.0
            track.add(t, (t, 0.0, 0.0))

    thread = threading.Thread(target=grow)
    thread.start()
    try:
        for _ in range(50):
            stamps, positions = track.arrays()
            assert len(stamps) == len(positions)
            assert len(stamps) == 0 or positions[-1, 0] == stamps[-1]
    finally:
        stop.set()
        thread.join()
