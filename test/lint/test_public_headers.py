# SPDX-License-Identifier: BSD-3-Clause
"""include/voxnav is what users of the library include: it compiles without the checkout, and reads as an index."""

import os
import re

from test_floors import FLOORS, ROOT, git_files

QUOTED = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
MAX_HEADERS = 53
OUTSIDE = ("src/bindings/*.?pp", "src/ros/*.?pp", "src/simulation/*.?pp", "include/voxnav_ros/*.hpp",
           "include/voxnav_simulation/*.hpp", "docs/examples/*.cpp")


def public_headers():
    return git_files("include/voxnav/*.hpp")


def included_by(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as header:
        return QUOTED.findall(header.read())


def exists(name):
    return os.path.exists(os.path.join(ROOT, "include", name))


def test_public_headers_include_public_headers_only():
    shown = [(path, name) for path in public_headers() for name in included_by(path) if not exists(name)]
    assert not shown, "internal headers in public ones"


def test_public_headers_do_not_show_the_libraries_behind_them():
    shown = [(path, name) for path in public_headers()
             for name in re.findall(r"#include <((?:ceres|octomap|pcl|yaml-cpp|boost|embree3)/[^>]*)>",
                                    open(os.path.join(ROOT, path), encoding="utf-8").read())]
    assert not shown


def test_nobody_outside_the_core_looks_behind_them():
    internal = re.compile("(?:%s)/" % "|".join(FLOORS))
    looking = [(path, name) for path in git_files(*OUTSIDE) for name in included_by(path) if internal.match(name)]
    assert not looking, "these include headers of src/core"


def test_each_of_them_is_for_somebody_outside_the_core():
    """It is included from there, or by a public header that is."""
    wanted, found = set(), {name for path in git_files(*OUTSIDE) for name in included_by(path)}
    while found:
        wanted |= found
        found = {name for header in found if exists(header) for name in included_by("include/" + header)} - wanted
    unwanted = [path for path in public_headers() if path[len("include/"):] not in wanted]
    assert not unwanted, "nobody outside the core needs these"


def test_they_are_few_enough_to_be_an_index():
    assert len(public_headers()) <= MAX_HEADERS
