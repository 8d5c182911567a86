# SPDX-License-Identifier: BSD-3-Clause
"""Without Matplotlib, as on an aircraft, modules can be imported, and commands that draw name the missing package."""

import subprocess
import sys

import pytest

# Makes the import of Matplotlib fail in a fresh interpreter, as it does where the package is not installed.
WITHOUT = "import sys; sys.modules['matplotlib'] = None\n"


def run(code):
    result = subprocess.run([sys.executable, "-c", WITHOUT + code], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            universal_newlines=True, timeout=120)
    return result.returncode, result.stdout + result.stderr


@pytest.mark.parametrize("module", ["voxnav.offline.cli", "voxnav.demo.flight", "voxnav.demo.recording",
                                    "voxnav.merging", "voxnav.alignment.cli"])
def test_modules_are_imported_without_matplotlib(module):
    assert run("import %s" % module) == (0, "")


def test_a_flight_leaves_a_note_instead_of_a_picture(tmp_path):
    code, text = run("from argparse import Namespace\n"
                     "from voxnav.demo.record import FlightRecord\n"
                     "from voxnav.demo.rviz import show\n"
                     "record = FlightRecord('forest', 1)\n"
                     "print(show(Namespace(out=%r, no_rviz=True), {}, record, None, ''))" % str(tmp_path))
    assert code == 0 and "python3-matplotlib" in text
    assert not list(tmp_path.iterdir())


def test_an_evaluation_ends_before_it_flies(tmp_path):
    code, text = run("from voxnav.alignment.cli import main\nmain(['--out', %r])" % str(tmp_path / "out"))
    assert code == 1
    assert text.startswith("pictures need Matplotlib (package python3-matplotlib)")
    assert not list(tmp_path.iterdir())
