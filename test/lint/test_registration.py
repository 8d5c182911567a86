# SPDX-License-Identifier: BSD-3-Clause
"""Every test is registered, so that `make test` and `catkin test` run it."""

import os

from test_floors import ROOT, git_files


def read(name):
    with open(os.path.join(ROOT, name), encoding="utf-8") as text:
        return text.read()


def test_every_cpp_test_is_listed_where_it_lies():
    files = git_files("test/unit/*.cpp", "test/property/*.cpp")
    assert len(files) > 50
    assert not [path for path in files
                if os.path.basename(path) not in read(os.path.join(os.path.dirname(path), "CMakeLists.txt"))
                and not path.startswith("test/unit/simulation")]  # CMakeLists.txt puts their names together


def test_every_folder_of_unit_tests_is_added():
    folders = {path.split("/")[2] for path in git_files("test/unit/*/CMakeLists.txt")}
    assert folders and not [name for name in folders if name not in read("test/CMakeLists.txt")]


def test_every_rostest_has_its_script():
    tests = {os.path.splitext(os.path.basename(path))[0] for path in git_files("test/rostest/*.test")}
    scripts = {os.path.basename(path)[:-len("_test.py")] for path in git_files("test/rostest/*_test.py")}
    assert tests and tests == scripts
