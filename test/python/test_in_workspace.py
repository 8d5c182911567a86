# SPDX-License-Identifier: BSD-3-Clause
"""scripts/dev/in_workspace hands every argument to the command, and none to the workspace's setup file."""

import os
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPT = os.path.join(ROOT, "scripts", "dev", "in_workspace")


def run(*arguments):
    return subprocess.run([SCRIPT, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)


def workspace(tmp_path):
    """Returns a workspace whose setup file reads the arguments that it sees, as catkin's does."""
    (tmp_path / "devel").mkdir()
    setup = '[[ $# -eq 0 ]] || { echo "setup got $*"; exit 7; }\nexport WS=here\n'
    (tmp_path / "devel" / "setup.bash").write_text(setup)
    return str(tmp_path)


def test_arguments_reach_the_command_alone(tmp_path):
    result = run(workspace(tmp_path), "bash", "-c", 'printf "%s|" "${WS}" "$@"', "name", "--help", "two words", "")
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout == "here|--help|two words||"


def test_the_status_of_the_command_is_kept(tmp_path):
    assert run(workspace(tmp_path), "bash", "-c", "exit 3").returncode == 3


def test_a_folder_that_is_no_built_workspace_is_named(tmp_path):
    result = run(str(tmp_path / "nothing"), "true")
    assert result.returncode == 1
    assert "nothing is no built workspace" in result.stderr and "make build" in result.stderr


def test_without_a_command_the_usage_is_printed(tmp_path):
    result = run(workspace(tmp_path))
    assert result.returncode == 2
    assert "usage: in_workspace WS COMMAND" in result.stderr
