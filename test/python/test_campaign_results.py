# SPDX-License-Identifier: BSD-3-Clause
"""flights.csv keeps every finished flight, whatever interrupts the campaign, and never writes 0 for what is unknown."""

import csv
import os

import pytest

from campaign_fakes import summary
from voxnav.campaign.errors import CampaignError
from voxnav.campaign.grid import FlightTask
from voxnav.campaign.results import FlightResults
from voxnav.campaign.rows import FlightRow, key_of_task, row_of
from voxnav.campaign.worlds import WorldText

ASKED = ["seed", "trees_per_ha", "speed_mps", "reached", "reason", "min_clearance_m", "path_ratio", "mean_speed_mps",
         "hovers", "shortened", "seconds"]
KNOWN = FlightRow(1000, 300.0, 4.0, True, "goal reached", 1.25, 1.0667, 4.0, 0, 2, 20.0, "forest", True, False, 31.5)
UNKNOWN = FlightRow(7, 450.0, None, reason='crashed: "no, nothing"', world="grove")


def open_results(tmp_path):
    return FlightResults(str(tmp_path / "flights.csv"))


def write(tmp_path, rows):
    with open_results(tmp_path) as results:
        for row in rows:
            results.append(row)
    return (tmp_path / "flights.csv").read_bytes()


def test_rows_come_back_as_they_were(tmp_path):
    write(tmp_path, [KNOWN, UNKNOWN])
    with open_results(tmp_path) as results:
        assert results.rows == [KNOWN, UNKNOWN]
        assert results.keys() == {KNOWN.key, UNKNOWN.key}
        assert results.repaired == ""


def test_columns_and_empty_cells(tmp_path):
    write(tmp_path, [KNOWN, UNKNOWN])
    with open(str(tmp_path / "flights.csv"), newline="") as source:
        header, known, unknown = csv.reader(source)
    assert header[:11] == ASKED
    assert known[:11] == ["1000", "300", "4", "true", "goal reached", "1.25", "1.0667", "4", "0", "2", "20"]
    assert unknown[2:4] == ["", ""] and unknown[5:11] == [""] * 6


def test_a_reason_stays_on_one_line(tmp_path):
    data = write(tmp_path, [KNOWN._replace(reason="stuck,\n behind\r\na \"tree\"")])
    assert data.count(b"\n") == 2
    with open_results(tmp_path) as results:
        assert results.rows[0].reason == 'stuck, behind a "tree"'


def test_a_file_that_is_cut_anywhere_keeps_its_whole_lines(tmp_path):
    path = tmp_path / "flights.csv"
    data = write(tmp_path, [KNOWN, UNKNOWN])
    for size in range(len(data)):
        path.write_bytes(data[:size])
        with open_results(tmp_path) as results:
            num_whole = max(0, data[:size].count(b"\n") - 1)
            assert results.rows == [KNOWN, UNKNOWN][:num_whole]
            assert bool(results.repaired) == (size > 0 and data[size - 1:size] != b"\n")
            for row in [KNOWN, UNKNOWN][num_whole:]:
                results.append(row)
        assert path.read_bytes() == data


def test_only_one_campaign_writes(tmp_path):
    with open_results(tmp_path):
        with pytest.raises(CampaignError, match="another campaign is writing"):
            open_results(tmp_path)
    open_results(tmp_path).close()


@pytest.mark.parametrize("line,problem", [
    ("1,300,2", "3 cells"), (",300,4,true,,,,,,,,forest,false,,", "must be known"),
    ("1,300,4,maybe,,,,,,,,forest,false,,", "neither true nor false"),
    ("x,300,4,true,,,,,,,,forest,false,,", "line 2")])
def test_lines_that_are_no_flights_are_named(tmp_path, line, problem):
    data = write(tmp_path, [])
    (tmp_path / "flights.csv").write_bytes(data + line.encode() + b"\n")
    with pytest.raises(CampaignError, match=problem):
        open_results(tmp_path)


def test_other_files_are_left_alone(tmp_path):
    path = tmp_path / "flights.csv"
    for text in ("a,b\n1,2\n", "\0\0\n"):
        path.write_text(text)
        with pytest.raises(CampaignError):
            open_results(tmp_path)
        assert path.read_text() == text


def test_a_full_disk_is_told(tmp_path, monkeypatch):
    with open_results(tmp_path) as results:
        real_write = os.write
        monkeypatch.setattr(os, "write", lambda file, data: real_write(file, data[:5]))
        with pytest.raises(OSError, match="full"):
            results.append(KNOWN)


def task():
    return FlightTask(WorldText("forest", "", 300.0), 1000, 4.0, True)


def test_the_row_of_a_summary():
    row = row_of(task(), "", summary(), 31.5)
    assert row == KNOWN._replace(path_ratio=80.0 / 75.0)
    assert row.key == key_of_task(task()) and row.is_success


def test_what_a_summary_does_not_know_stays_unknown():
    row = row_of(task(), "", summary(reached=False, reason="take-off refused", min_clearance_m=None, has_collided=None,
                                     path_length_m=0.0, straight_m=None, flight_s=None, num_hovers=None,
                                     num_shortened=None))
    assert row.reached is False and row.reason == "take-off refused"
    assert row[5:11] == (None,) * 6 and row.collided is None and row.wall_s is None


def test_a_flight_that_stood_still_has_a_mean_speed_of_zero():
    row = row_of(task(), "", summary(path_length_m=0.0, straight_m=0.0))
    assert row.mean_speed_mps == 0.0 and row.path_ratio is None


@pytest.mark.parametrize("changes", [{"reached": False}, {"reached": None}, {"collided": True}, {"collided": None}])
def test_no_success_without_knowing_it(changes):
    assert not KNOWN._replace(**changes).is_success


def test_the_outcome_is_a_sentence():
    assert KNOWN.outcome == "goal reached, smallest clearance 1.25 m"
    assert KNOWN._replace(collided=True).outcome == "COLLIDED; goal reached, smallest clearance 1.25 m"
    assert KNOWN._replace(collided=None).outcome.endswith("1.25 m, whether it collided is not known")
    assert UNKNOWN.outcome == 'crashed: "no, nothing"'
    assert str(KNOWN) == "forest, 300 trees/ha, up to 4 m/s, seed 1000, faults"
