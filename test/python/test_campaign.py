# SPDX-License-Identifier: BSD-3-Clause
"""scripts/campaign flies a grid on Dask, keeps every result, goes on after interruptions and tells what failed."""

import contextlib
import csv
import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

import campaign_fakes
from voxnav.campaign import cli, runner
from voxnav.campaign.statistics import share_bounds

pytest.importorskip("distributed")
pytest.importorskip("matplotlib")
HERE = os.path.dirname(os.path.abspath(__file__))
GRID = ["--worlds", "grove", "--densities", "100,300", "--speeds", "2,4", "--workers", "2"]
LIMIT_S = 60.0


@pytest.fixture
def flown(tmp_path, monkeypatch):
    """Returns a function that returns the flights flown so far, (name, process), by campaign_fakes."""
    path = tmp_path / "flown"
    monkeypatch.setenv("VOXNAV_TEST_FLOWN", str(path))
    return lambda: [line.split() for line in path.read_text().splitlines()] if path.exists() else []


def campaign(out, *words, fly=campaign_fakes.fly):
    return cli.main(GRID + ["--out", str(out)] + list(words), fly)


def rows(out):
    with open(str(out / "flights.csv"), newline="") as source:
        return list(csv.DictReader(source))


def test_a_campaign_leaves_rows_and_a_report(tmp_path, capsys):
    assert campaign(tmp_path, "--seeds", "2,4") == 0
    found = rows(tmp_path)
    assert sorted((r["seed"], r["trees_per_ha"], r["speed_mps"]) for r in found) == sorted(
        (seed, density, speed) for seed in "24" for density in ("100", "300") for speed in "24")
    assert {(r["reached"], r["min_clearance_m"], r["mean_speed_mps"], r["faults"]) for r in found} == {
        ("true", "1.25", "4", "false")}
    text = capsys.readouterr().out
    assert "[8/8] grove" in text and "8 of 8 = 100 %% (%.0f to 100)" % (100 * share_bounds(8, 8).low) in text
    assert "Campaign of 8 flights" in (tmp_path / "report.html").read_text()


def test_failures_are_rows_and_are_shown(tmp_path):
    assert campaign(tmp_path, "--seeds", "1-4", "--faults", "on") == cli.FAILED
    by_seed = {row["seed"]: row for row in rows(tmp_path)}
    assert by_seed["1"]["reason"] == "stuck, behind a tree" and by_seed["1"]["collided"] == "true"
    assert by_seed["3"]["reason"] == "crashed: RuntimeError: the worker is broken"
    assert by_seed["3"]["reached"] == by_seed["3"]["min_clearance_m"] == by_seed["3"]["hovers"] == ""
    text = (tmp_path / "report.html").read_text()
    assert "Failures: 8" in text
    world = tmp_path / "worlds" / "grove_100trees.yaml"
    assert "scripts/demo --world %s --seed 1 --limit 300 --max-speed 2 --faults" % world in text
    assert world.exists()


def test_a_campaign_goes_on_where_it_was(tmp_path, flown, capsys):
    assert campaign(tmp_path, "--seeds", "2,4", "--flights", "3") == 0
    assert len(flown()) == len(rows(tmp_path)) == 3
    with open(str(tmp_path / "flights.csv"), "a") as out:
        out.write("2,100,4,tr")
    assert campaign(tmp_path, "--seeds", "2,4,6") == 0
    names = [name for name, _ in flown()]
    assert len(names) == len(set(names)) == len(rows(tmp_path)) == 12
    text = capsys.readouterr().out
    assert "3 of 12 flights are in" in text and "cut off and is removed: 2,100,4,tr" in text
    assert "[9/9]" in text


def test_flights_of_other_settings_are_not_mixed(tmp_path, capsys):
    campaign(tmp_path, "--seeds", "2", "--flights", "1")
    assert campaign(tmp_path, "--seeds", "2", "--limit", "100") == 1
    assert "flown with another settings.json; choose another folder" in capsys.readouterr().err
    (tmp_path / "worlds" / "grove_300trees.yaml").write_text("trees_per_ha: 300.0\n")
    assert campaign(tmp_path, "--seeds", "2") == 1
    assert "grove_300trees.yaml" in capsys.readouterr().err


@pytest.mark.parametrize("words,problem", [
    (["--seeds", "9-1"], "no range of seeds"), (["--seeds", "1", "--speeds", "0"], "below 0.1"),
    (["--seeds", "1", "--worlds", "nowhere"], "no world nowhere"),
    (["--seeds", "1", "--config", "missing.yaml"], "cannot be read"),
    (["--seeds", "1", "--scheduler", "tcp://127.0.0.1:1"], "no Dask scheduler answers")])
def test_bad_input_ends_with_a_message(tmp_path, capsys, monkeypatch, words, problem):
    monkeypatch.setattr(runner, "CONNECTION_LIMIT_S", 1.0)
    assert campaign(tmp_path / "out", *words) == 1
    assert problem in capsys.readouterr().err
    assert not (tmp_path / "out" / "flights.csv").exists()


def test_a_machine_without_dask_names_the_package(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert campaign(tmp_path, "--seeds", "1") == 1
    assert "python3-distributed" in capsys.readouterr().err


def start(*command, **environment):
    paths = os.pathsep.join([HERE, os.environ.get("PYTHONPATH", "")])
    return subprocess.Popen(command, env=dict(os.environ, PYTHONPATH=paths, **environment), stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, universal_newlines=True)


def wait_until(condition, what):
    deadline = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline, "waited in vain for " + what
        time.sleep(0.05)


@contextlib.contextmanager
def cluster(tmp_path):
    """Yields the address of a Dask scheduler, its process, and the process of its one worker."""
    address_file = tmp_path / "scheduler.json"
    scheduler = start("dask-scheduler", "--port", "0", "--host", "127.0.0.1", "--no-dashboard", "--scheduler-file",
                      str(address_file))
    worker = start("dask-worker", "--scheduler-file", str(address_file), "--nthreads", "2", "--no-nanny",
                   "--no-dashboard")
    try:
        wait_until(lambda: address_file.exists() and address_file.read_text().endswith("}"), "the scheduler")
        yield json.loads(address_file.read_text())["address"], scheduler, worker
    finally:
        for process in (worker, scheduler):
            process.kill()
            process.communicate(timeout=LIMIT_S)


def test_a_campaign_flies_on_a_running_scheduler(tmp_path, flown):
    with cluster(tmp_path) as (address, _, worker):
        assert campaign(tmp_path / "out", "--seeds", "2,4", "--scheduler", address) == 0
        assert {process for _, process in flown()} == {str(worker.pid)}
    assert len(rows(tmp_path / "out")) == 8


def test_a_campaign_whose_scheduler_is_lost_ends_and_can_go_on(tmp_path, flown, capsys):
    with cluster(tmp_path) as (address, scheduler, _):
        killer = threading.Thread(target=lambda: (wait_until(flown, "the first flight"), scheduler.kill()))
        killer.start()
        assert campaign(tmp_path / "out", "--seeds", "2,4", "--scheduler", address,
                        fly=campaign_fakes.fly_slowly) == 1
        killer.join()
    assert "scheduler was lost" in capsys.readouterr().err
    assert campaign(tmp_path / "out", "--seeds", "2,4") == 0
    assert len(rows(tmp_path / "out")) == 8


INTERRUPTED = """
import sys, time
import campaign_fakes
from voxnav.campaign import cli, flight

def fly(task):
    if task.seed == 2:
        return campaign_fakes.fly(task)
    print("a long flight begins", flush=True)
    flight._PROGRAM = ("-c", "import time; time.sleep(1000)")
    return flight.fly(task)

sys.exit(cli.main(sys.argv[1:], fly))
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_campaign_keeps_its_rows_and_ends_its_flights(tmp_path, flown, number):
    process = start(sys.executable, "-c", INTERRUPTED, "--worlds", "grove", "--seeds", "2,4", "--workers", "2", "--out",
                    str(tmp_path))
    for line in process.stdout:
        if "long flight begins" in line:
            break
    wait_until(lambda: (tmp_path / "flights.csv").exists() and len(rows(tmp_path)) == 1, "the first row")
    process.send_signal(number)
    process.communicate(timeout=LIMIT_S)
    assert process.returncode == {signal.SIGINT: cli.INTERRUPTED, signal.SIGTERM: 128 + signal.SIGTERM}[number]
    assert len(rows(tmp_path)) == 1
    assert "Campaign of 1 flights" in (tmp_path / "report.html").read_text()
    assert cli.main(["--worlds", "grove", "--seeds", "2,4", "--workers", "1", "--out", str(tmp_path)],
                    campaign_fakes.fly) == 0
    assert [name for name, _ in flown()] == ["grove_300trees_seed2", "grove_300trees_seed4"]
