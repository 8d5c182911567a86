# SPDX-License-Identifier: BSD-3-Clause
"""The report of a campaign tells what was flown, with bounds, and shows every failure with its picture and command."""

import base64
import re

import pytest

from campaign_fakes import PICTURE
from voxnav.campaign.report import summary_lines, write_report
from voxnav.campaign.rows import FlightRow
from voxnav.campaign.table import (by_density_and_speed, clearance_words, groups, motion_words, speeds, stop_words,
                                   success_words)

GOOD = FlightRow(0, 300.0, 4.0, True, "goal reached", 1.25, 1.07, 3.0, 0, 2, 25.0, "forest", False, False, 30.0)


def rows():
    """Returns 10 flights in each of two cells, 9 of which are good in the second, and one without a result."""
    out = [GOOD._replace(seed=seed, min_clearance_m=1.0 + 0.01 * seed) for seed in range(10)]
    out += [row._replace(speed_mps=6.0) for row in out[:9]]
    out.append(GOOD._replace(seed=9, speed_mps=6.0, reached=False, collided=True, reason="stuck <here>",
                             min_clearance_m=0.2, hovers=4))
    out.append(FlightRow(7, 600.0, 4.0, reason="hung: no end after 9 s", world="forest"))
    return out


def report(tmp_path, flights, picture=lambda row: None):
    path = tmp_path / "report.html"
    write_report(str(path), flights, lambda row: "scripts/demo --seed %d" % row.seed, picture)
    return path.read_text()


def test_cells_count_flights_and_not_only_successes():
    table, header = by_density_and_speed(groups(rows())[0], success_words)
    assert header == ["trees per hectare", "up to 4 m/s", "up to 6 m/s"]
    assert table == [["300", "10 of 10 = 100 % (69 to 100)", "9 of 10 = 90 % (55 to 100)"],
                     ["600", "0 of 1 = 0 % (0 to 98)", "-"]]


def test_clearance_is_of_flights_in_which_it_is_known():
    assert clearance_words(rows()[:10]) == "1.00 | 1.00 (? to 1.02) | 1.04 (1.01 to 1.08)"
    assert clearance_words(rows()[20:]) == motion_words(rows()[20:]) == stop_words(rows()[20:]) == "not measured"
    assert motion_words(rows()[:1]) == "3.00 m/s, 1.070"
    assert stop_words(rows()[18:20]) == "2.00, 2.00"


def test_summary_names_the_worst():
    lines = summary_lines(rows())
    assert lines[0].endswith("19 of 21 = 90 % (70 to 99)")
    assert lines[1] == "collisions: 1 of 20 = 5 % (0 to 25)"
    assert lines[2] == "smallest clearance: 0.20 m (forest, 300 trees/ha, up to 6 m/s, seed 9)"
    assert lines[3] == ("smallest | 5 % quantile | median of the clearances of all flights: "
                        "0.20 | 0.20 (? to 1.01) | 1.04 (1.02 to 1.06) m")
    assert lines[4].endswith(": 1")


def test_worlds_and_faults_are_told_apart():
    flights = [GOOD, GOOD._replace(world="grove"), GOOD._replace(faults=True), GOOD._replace(speed_mps=None)]
    assert [(g.title, len(g.rows)) for g in groups(flights)] == [
        ("forest, faults off", 2), ("forest, faults on", 1), ("grove, faults off", 1)]
    assert speeds(flights) == [None, 4.0]


def test_every_failure_has_its_reason_command_and_picture(tmp_path):
    pytest.importorskip("matplotlib")
    text = report(tmp_path, rows(), lambda row: PICTURE if row.collided else None)
    assert "Failures: 2" in text
    assert "COLLIDED; stuck &lt;here&gt;, smallest clearance 0.20 m" in text and "<here>" not in text
    assert "hung: no end after 9 s" in text
    assert text.count("scripts/demo --seed 9") == 1 and text.count("scripts/demo --seed 7") == 1
    assert base64.b64encode(PICTURE).decode() in text and text.count("There is no picture") == 1
    assert "Clopper-Pearson" in text and "order statistics" in text
    figures = [base64.b64decode(data) for data in re.findall(r'data:image/png;base64,([^"]*)"', text)]
    assert sum(data.startswith(b"\x89PNG\r\n") for data in figures) == 2


def test_a_report_without_any_result(tmp_path):
    text = report(tmp_path, rows()[20:])
    assert "Campaign of 1 flights" in text and "0 of 1 = 0 %" in text and "collisions: none" in text


def test_a_report_that_cannot_be_written_leaves_the_last_one(tmp_path):
    before = report(tmp_path, rows()[:3])

    def fail(row):
        raise OSError("no picture can be read")
    with pytest.raises(OSError):
        report(tmp_path, rows(), fail)
    assert (tmp_path / "report.html").read_text() == before
