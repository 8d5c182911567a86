# SPDX-License-Identifier: BSD-3-Clause
"""A command that hangs fails its test and leaves no process behind."""

import os
import sys
import time

import pytest
from running import run_command

# Starts a process that runs for ever, and says which one it is.
HANGS = ("import subprocess, sys; child = subprocess.Popen([sys.executable, '-c', 'while True: input()'],"
         " stdin=subprocess.PIPE); print('child', child.pid, flush=True); child.wait()")


def has_ended(process):
    """Returns whether a process ends before long; it is still listed until the system has taken note of its end."""
    end = time.monotonic() + 30.0
    while time.monotonic() < end:
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.01)
    return False


def test_a_command_that_ends_gives_its_exit_code_and_what_it_printed():
    done = run_command([sys.executable, "-c", "import sys; print('word'); sys.exit(3)"])
    assert (done.returncode, done.stdout) == (3, "word\n")


def test_a_command_that_hangs_is_ended_with_all_that_it_started():
    with pytest.raises(AssertionError, match="has not ended after 1 s") as failure:
        run_command([sys.executable, "-c", HANGS], limit_s=1)
    words = str(failure.value).split()
    child = int(words[len(words) - 1 - words[::-1].index("child") + 1])
    assert has_ended(child)
