# SPDX-License-Identifier: BSD-3-Clause
"""One flight of a campaign: scripts/demo in lock-step, as a process of its own on a master of its own."""

from __future__ import annotations

import json
import os
import shlex
import signal
import sys
import tempfile
import time
import uuid
from typing import Any, NamedTuple

from voxnav.campaign.grid import FlightTask
from voxnav.campaign.rows import FlightRow, row_of
from voxnav.demo.processes import Process

_PROGRAM = ("-m", "voxnav.demo")  # scripts/demo, as Python runs it wherever voxnav is installed
_KEPT_OF_FAILURES = ("top_view.png", "summary.json", "roslaunch.log", "demo.log")
_KEPT = ("summary.json",)
_MAX_KEPT_BYTES = 2000000
_LOOK_S = 0.2
# A flight that is stopped has this long to end its nodes.
_PATIENCE_S = 60.0
# Processes of a flight inherit this variable, by which those that are left over are found.
_MARK = "VOXNAV_FLIGHT"
_stopped: set[str] = set()
_flying: list[str] = []  # the campaign of each flight that this process flies at present


class FlightResult(NamedTuple):
    """The row of a flight, and the files that are worth keeping, by name."""

    row: FlightRow
    files: dict[str, bytes]


def stop_flights(campaign: str) -> None:
    """Stops the flights of a campaign that this process flies; they end as soon as their nodes have ended."""
    _stopped.add(campaign)


def num_flying(campaign: str) -> int:
    """Returns how many flights of a campaign this process flies at present."""
    return _flying.count(campaign)


def arguments(task: FlightTask, world: str, config: str, out: str) -> list[str]:
    """Returns the arguments of scripts/demo for a flight. world, config: paths of files; config may be ""."""
    out_arguments = ["--world", world, "--seed", str(task.seed), "--limit", "%g" % task.limit_s]
    if task.speed_mps is not None:
        out_arguments += ["--max-speed", "%g" % task.speed_mps]
    if task.has_faults:
        out_arguments.append("--faults")
    if config:
        out_arguments += ["--config", config]
    return out_arguments + ["--lockstep", "--speed", "0", "--no-rviz", "--out", out]


def replay_command(task: FlightTask, world: str, config: str, out: str) -> str:
    """Returns the command that flies the same flight again."""
    return " ".join(shlex.quote(word) for word in ["scripts/demo"] + arguments(task, world, config, out))


def fly(task: FlightTask) -> FlightResult:
    """Flies in a folder of its own, which is removed. Whatever happens ends as a row with a reason."""
    started = time.monotonic()
    _flying.append(task.campaign)
    try:
        with tempfile.TemporaryDirectory(prefix="voxnav_flight_") as folder:
            reason, summary = "", None
            try:
                _run(task, folder, started)
                summary = _summary(folder)
            except _NoResult as error:
                reason = str(error)
            row = row_of(task, reason, summary, time.monotonic() - started)
            return FlightResult(row, _files(folder, _KEPT if row.is_success else _KEPT_OF_FAILURES))
    finally:
        _flying.remove(task.campaign)


class _NoResult(RuntimeError):
    """A flight ended without a result; the text says how."""


def _run(task: FlightTask, folder: str, started: float) -> None:
    """Runs scripts/demo until it has left its summary. Raises _NoResult."""
    paths = {"world": os.path.join(folder, task.world.name + ".yaml"), "config": os.path.join(folder, "config.yaml")}
    for name, text in (("world", task.world.text), ("config", task.config)):
        with open(paths[name], "w") as out:
            out.write(text)
    command = [sys.executable, *_PROGRAM, "--end-with-parent"] + arguments(
        task, paths["world"], paths["config"] if task.config else "", folder)
    mark = uuid.uuid4().hex
    # Threads of linear algebra would only take the processors from the flights beside this one.
    env = dict(os.environ, OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", **{_MARK: mark})
    env.pop("DISPLAY", None)
    process = Process(command, os.path.join(folder, "demo.log"), env, ends_with_this=True)
    try:
        while process.is_running():
            time.sleep(_LOOK_S)
            if task.campaign in _stopped:
                raise _NoResult("the campaign was interrupted")
            if time.monotonic() - started > task.wall_limit_s:
                raise _NoResult("hung: no end after %g s" % task.wall_limit_s)
        # The status is 1 if the goal was not reached, of which the summary tells, and also after an exception.
        if process.exit_status not in (0, 1) or not os.path.exists(os.path.join(folder, "summary.json")):
            raise _NoResult("crashed (status %s): %s" % (
                process.exit_status, _last_line(os.path.join(folder, "demo.log"))))
    finally:
        process.stop(_PATIENCE_S)
        _end_left_over(mark)


def _summary(folder: str) -> dict[str, Any]:
    """Raises _NoResult if the summary cannot be read, as on a full disk."""
    try:
        with open(os.path.join(folder, "summary.json")) as source:
            return dict(json.load(source))
    except (OSError, ValueError, TypeError) as error:
        raise _NoResult("its summary cannot be read: %s" % error) from error


def _last_line(path: str) -> str:
    with open(path, errors="replace") as source:
        lines = [line.strip() for line in source if line.strip()]
    return lines[-1] if lines else "it printed nothing"


def _files(folder: str, names: tuple[str, ...]) -> dict[str, bytes]:
    out = {}
    for name in names:
        path = os.path.join(folder, name)
        if os.path.exists(path):
            with open(path, "rb") as source:
                source.seek(max(0, os.path.getsize(path) - _MAX_KEPT_BYTES))
                out[name] = source.read()
    return out


def _end_left_over(mark: str) -> None:
    """Kills processes of a flight that have outlived it, wherever in the tree of processes they are."""
    wanted = ("%s=%s" % (_MARK, mark)).encode()
    for entry in os.listdir("/proc"):
        if not entry.isdigit():
            continue
        try:
            with open("/proc/%s/environ" % entry, "rb") as source:
                if wanted in source.read().split(b"\0"):
                    os.kill(int(entry), signal.SIGKILL)
        except OSError:
            continue  # it has ended, or it belongs to somebody else
