# SPDX-License-Identifier: BSD-3-Clause
"""Every command that README.md, CONTRIBUTING.md and docs/ show is run by a test.

Scripts are run here with ``--help``, so that the options that a page shows are known to exist. Commands that build or
fly are run by the test that TESTS names; here only that name is checked, and what make would do.
"""

import os
import re
import shlex
import shutil
import subprocess
from xml.etree import ElementTree

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGES = ["README.md", "CONTRIBUTING.md"] + sorted(
    os.path.join(folder, name)[len(ROOT) + 1:] for folder, _, names in os.walk(os.path.join(ROOT, "docs"))
    for name in names if name.endswith(".md"))
FENCE = re.compile(r"^ *```([^\n]*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"`((?:make|roslaunch|rosservice|catkin|cmake|pre-commit|scripts/\w+(?:/\w+)?) [^`]+)`")

# Commands that take too long or change too much to be run here: the beginning of the command, and the file that runs it
# with a text in that file.
TESTS = {
    "catkin build voxnav": ("scripts/dev/build_workspace", "catkin_make"),  # builds the same package in a workspace
    "catkin test voxnav": ("scripts/dev/run_tests", "ctest"),  # runs the same tests
    "catkin config --install": ("scripts/dev/run_install_tests", "catkin_make install"),
    "cmake --install": ("scripts/dev/run_install_tests", "cmake --install"),
    ". /opt/voxnav/setup.bash": ("scripts/dev/build_deb", "-DCMAKE_INSTALL_PREFIX=/opt/voxnav"),
    "rosservice call /uav1/planning_manager/goto": ("test/rostest/planning_manager_test.py", "planning_manager/goto"),
    "rosservice call /uav1/planning_manager/stop": ("test/rostest/planning_manager_test.py", "planning_manager/stop"),
    "rosservice call /uav1/octomap_planner/goto": ("test/rostest/octomap_planner_test.py", '"octomap_planner/goto"'),
    "rosservice call /uav1/octomap_planner/stop": ("test/rostest/octomap_planner_test.py", '"octomap_planner/stop"'),
    "rosbag play --clock flight.bag": ("test/python/test_rosbag_play.py", '"rosbag", "play", "--clock"'),
    "dask-scheduler": ("test/python/test_campaign.py", '"dask-scheduler"'),
    "scripts/dev/in_workspace build/ws dask-worker": ("test/python/test_campaign.py", '"dask-worker"'),
    "pre-commit install": ("test/lint/test_hooks.py", ".pre-commit-config.yaml"),
    "cd build/ws/build/voxnav/test && ctest": ("scripts/dev/run_tests", "ctest"),
}


def commands():
    """Returns (page, command) for every line of shell code, and for commands within sentences."""
    found = []
    for page in PAGES:
        with open(os.path.join(ROOT, page), encoding="utf-8") as source:
            text = source.read()
        for language, block in FENCE.findall(text):
            if language in ("", "bash", "sh"):
                lines = re.sub(r" #.*$", "", block.replace("\\\n", " "), flags=re.MULTILINE).splitlines()
                found += [(page, line.strip()) for line in lines if line.strip()]
        found += [(page, command) for command in INLINE.findall(FENCE.sub("", text))]
    return sorted(set(found))


def run(command):
    environment = dict(os.environ, PATH="/usr/bin:" + os.environ["PATH"])
    done = subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          universal_newlines=True, timeout=120)
    assert done.returncode == 0, "%s: %s" % (" ".join(command), done.stdout)
    return done.stdout


def check_make(words):
    """Asks make what it would do, and checks that the programs that it would run exist."""
    assert shutil.which("make"), "make is not installed"
    # With -n make still runs the commands that call make itself; MAKE=true turns them into calls of `true`.
    plan = run(["make", "-n", "--no-print-directory", "MAKE=true"] + words[1:])
    programs = set(re.findall(r"scripts/[\w/]+", plan))
    for program in programs:
        assert os.access(os.path.join(ROOT, program), os.X_OK), "%s: %s cannot be run" % (words, program)
    assert programs or re.search(r"^(cmake|git ls-files|rm -rf build|grep)", plan, re.MULTILINE), plan


def check_script(words):
    """Runs a script with --help, and checks that its output has every option that the page shows."""
    path = os.path.join(ROOT, words[0])
    assert os.access(path, os.X_OK), "%s cannot be run" % words[0]
    with open(path) as source:
        is_python = "python" in source.readline()
    if words[0] == "scripts/dev/in_workspace":
        assert words[1] == "build/ws", "pages use the workspace that make build leaves"
        return check(words[2:])
    if not is_python:
        return run(["bash", "-n", path])
    text = run(["/usr/bin/python3", path, "--help"]) if has_arguments(path) else ""
    missing = [word for word in words[1:] if word.startswith("--") and word not in text]
    assert not missing, "%s has no %s" % (words[0], missing)


def has_arguments(path):
    """Returns whether a script takes arguments; the others would ignore --help and do their work."""
    return os.path.basename(path) not in ("make_parameter_docs", "make_stubs")


def check_launch(words):
    """Checks that a launch file has the arguments that the page gives it; test_launch.py loads the file."""
    assert words[1] == "voxnav"
    tree = ElementTree.parse(os.path.join(ROOT, "launch", words[2]))
    names = {arg.get("name") for arg in tree.getroot().findall("arg")}
    assert {word.split(":=")[0] for word in words[3:]} <= names, names


def check_pytest(words):
    assert words[1:3] == ["-m", "pytest"]
    assert all(os.path.exists(os.path.join(ROOT, word)) for word in words[3:] if word.startswith("test/"))


def check(words):
    checks = {"make": check_make, "roslaunch": check_launch, "python3": check_pytest}
    if words[0] in checks:
        return checks[words[0]](words)
    assert words[0].startswith("scripts/"), "no test runs `%s`; say in TESTS which one does" % " ".join(words)
    return check_script(words)


@pytest.mark.parametrize("page,command", commands(), ids=["%s: %s" % each for each in commands()])
def test_documented_command(page, command):
    for beginning, (path, text) in TESTS.items():
        if command.startswith(beginning):
            with open(os.path.join(ROOT, path)) as source:
                assert text in source.read(), "%s does not run %s" % (path, beginning)
            return
    check([word for word in shlex.split(command) if word not in ("[", "]")])


def test_pages_show_commands():
    assert len(commands()) > 20


@pytest.mark.parametrize("beginning", sorted(TESTS))
def test_what_is_tested_elsewhere_is_still_documented(beginning):
    assert any(command.startswith(beginning) for _, command in commands())
