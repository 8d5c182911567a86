# SPDX-License-Identifier: BSD-3-Clause
"""A flight of a campaign is a process: whatever it does ends as a row with a reason, and nothing of it goes on."""

import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from campaign_fakes import summary
from voxnav.campaign import flight
from voxnav.campaign.grid import FlightTask
from voxnav.campaign.worlds import WorldText

LIMIT_S = 60.0  # limit of wall time for every wait
WORLD = WorldText("forest", "trees_per_ha: 300.0\n", 300.0)
TASK = FlightTask(WORLD, 5, 4.0, True, config="a: 1\n", wall_limit_s=LIMIT_S)


def run(monkeypatch, program, task=TASK):
    """Runs Python code in place of scripts/demo. Its arguments are those of scripts/demo."""
    monkeypatch.setattr(flight, "_PROGRAM", ("-c", program))
    monkeypatch.setattr(flight, "_PATIENCE_S", 1.0)
    return flight.fly(task)


def writing(content):
    """Returns code that writes a summary.json."""
    return ("import sys\nout = sys.argv[sys.argv.index('--out') + 1]\n"
            "open(out + '/summary.json', 'w').write(%r)\n" % json.dumps(content))


def wait_until(condition, what):
    deadline = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline, "waited in vain for " + what
        time.sleep(0.02)


def is_running(pid):
    try:
        with open("/proc/%d/stat" % pid) as source:
            return source.read().split(")")[1].split()[0] != "Z"
    except OSError:
        return False


def test_a_flight_that_reached_its_goal(monkeypatch):
    result = run(monkeypatch, writing(summary()))
    assert result.row.is_success and result.row.min_clearance_m == 1.25
    assert result.row.wall_s > 0.0
    assert set(result.files) == {"summary.json"}


def test_a_flight_that_did_not_reach_its_goal_leaves_its_logs(monkeypatch):
    code = writing(summary(reached=False, reason="stuck")) + "print('the nodes say')\nsys.exit(1)"
    result = run(monkeypatch, code)
    assert result.row.reached is False and result.row.reason == "stuck"
    assert result.files["demo.log"] == b"the nodes say\n"


def test_the_flight_gets_what_the_task_says(monkeypatch):
    code = ("import sys\nat = sys.argv.index\n"
            "print([sys.argv[at(name) + 1] for name in ('--seed', '--max-speed', '--limit', '--speed')])\n"
            "print([name in sys.argv for name in ('--faults', '--lockstep', '--no-rviz', '--end-with-parent')])\n"
            "print(open(sys.argv[at('--world') + 1]).read() + open(sys.argv[at('--config') + 1]).read())\n")
    log = run(monkeypatch, code).files["demo.log"].decode()
    assert log == "['5', '4', '300', '0']\n[True, True, True, True]\ntrees_per_ha: 300.0\na: 1\n\n"


@pytest.mark.parametrize("code,reason", [
    ("raise ValueError('no such sensor')", "crashed (status 1): ValueError: no such sensor"),
    ("import os; os.abort()", "crashed (status -6): it printed nothing"),
    ("print('bye'); exit(4)", "crashed (status 4): bye"),
    ("pass", "crashed (status 0): it printed nothing"),
    (writing([1, 2]), "its summary cannot be read")])
def test_a_flight_without_a_result_has_a_reason_and_no_figures(monkeypatch, code, reason):
    result = run(monkeypatch, code)
    assert result.row.reason.startswith(reason)
    assert result.row.reached is None and result.row.min_clearance_m is None and result.row.hovers is None
    assert "demo.log" in result.files


def test_a_flight_that_hangs_is_ended_with_everything_that_it_started(monkeypatch, tmp_path):
    # The child ignores signals, and so does its own child, which is in another session.
    pids = tmp_path / "pids"
    code = ("import os, signal, subprocess, sys, time\n"
            "for number in (signal.SIGINT, signal.SIGTERM): signal.signal(number, signal.SIG_IGN)\n"
            "child = subprocess.Popen(['sleep', '1000'], start_new_session=True)\n"
            "open(%r, 'w').write('%%d %%d' %% (os.getpid(), child.pid))\n"
            "time.sleep(1000)" % str(pids))
    result = run(monkeypatch, code, TASK._replace(wall_limit_s=2.0))
    assert result.row.reason == "hung: no end after 2 s" and result.row.reached is None
    for pid in map(int, pids.read_text().split()):
        wait_until(lambda: not is_running(pid), "the end of %d" % pid)


def test_flights_of_an_interrupted_campaign_end_and_others_go_on(monkeypatch):
    results = {}
    codes = {"mine": "import time; time.sleep(1000)", "other": writing(summary())}

    def fly(name):
        results[name] = flight.fly(TASK._replace(campaign=name))
    monkeypatch.setattr(flight, "_PROGRAM", ("-c", codes["mine"]))
    thread = threading.Thread(target=fly, args=("mine",))
    thread.start()
    wait_until(lambda: flight.num_flying("mine") == 1, "the flight")
    flight.stop_flights("mine")
    thread.join(LIMIT_S)
    assert results["mine"].row.reason == "the campaign was interrupted" and flight.num_flying("mine") == 0
    monkeypatch.setattr(flight, "_PROGRAM", ("-c", codes["other"]))
    fly("other")
    assert results["other"].row.is_success


def test_a_flight_ends_with_a_worker_that_is_killed(tmp_path):
    pid_file = tmp_path / "pid"
    child = ("import os, time; from voxnav.demo.processes import end_with_parent; end_with_parent()\n"
             "open(%r, 'w').write(str(os.getpid()))\ntime.sleep(1000)" % str(pid_file))
    parent = ("import sys, time; from voxnav.demo.processes import Process\n"
              "process = Process([sys.executable, '-c', %r], ends_with_this=True)\ntime.sleep(1000)" % child)
    worker = subprocess.Popen([sys.executable, "-c", parent])
    wait_until(lambda: pid_file.exists() and pid_file.read_text(), "the flight")
    pid = int(pid_file.read_text())
    assert is_running(pid)
    os.kill(worker.pid, signal.SIGKILL)
    worker.wait()
    wait_until(lambda: not is_running(pid), "the end of the flight")


def test_the_replay_command_flies_the_same(monkeypatch):
    command = flight.replay_command(TASK, "my worlds/forest.yaml", "", "out")
    assert command == ("scripts/demo --world 'my worlds/forest.yaml' --seed 5 --limit 300 --max-speed 4 --faults "
                       "--lockstep --speed 0 --no-rviz --out out")
