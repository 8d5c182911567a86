# SPDX-License-Identifier: BSD-3-Clause
"""Runs the commands of voxnav that start nodes, and leaves no node behind."""

import os
import signal
import subprocess

# A command that takes longer hangs. A flight takes less than a minute on an idle machine, but tests also run on loaded
# ones.
LIMIT_S = 900
# How long roslaunch may take to end its nodes: it waits 15 s before it terminates and 2 s before it kills them.
END_S = 30


def end_group(process):
    """Ends all processes of a command, and returns what it printed."""
    for way in (signal.SIGINT, signal.SIGKILL):
        try:
            os.killpg(process.pid, way)
        except ProcessLookupError:
            pass
        try:
            return process.communicate(timeout=END_S)[0]
        except subprocess.TimeoutExpired:
            continue
    return ""


def run_command(command, limit_s=LIMIT_S, **options):
    """Runs a command and returns its exit code and what it printed, as subprocess.run does.

    The command gets a process group of its own. If it has not ended after ``limit_s`` seconds, the group is
    interrupted, as by Ctrl-C, and the test fails with the end of what it printed: killing the command alone would
    leave its nodes, which disturb the tests that follow.
    """
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True,
                               start_new_session=True, **options)
    try:
        printed = process.communicate(timeout=limit_s)[0]
        return subprocess.CompletedProcess(command, process.returncode, printed)
    except subprocess.TimeoutExpired:
        printed = end_group(process)
        raise AssertionError("%s has not ended after %d s; it printed:\n%s" % (command, limit_s, printed[-3000:]))
