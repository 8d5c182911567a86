# SPDX-License-Identifier: BSD-3-Clause
"""The headers in include/voxnav are for users of the library: they include no internal header, and they are few."""

import os
import re

from test_floors import FLOORS, ROOT, git_files

QUOTED = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
MAX_HEADERS = 61
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


def test_nothing_outside_the_core_includes_internal_headers():
    internal = re.compile("(?:%s)/" % "|".join(FLOORS))
    looking = [(path, name) for path in git_files(*OUTSIDE) for name in included_by(path) if internal.match(name)]
    assert not looking, "these include headers of src/core"


def test_every_public_header_is_used_outside_the_core():
    """Every public header is included outside the core, or by a public header that is."""
    wanted, found = set(), {name for path in git_files(*OUTSIDE) for name in included_by(path)}
    while found:
        wanted |= found
        found = {name for header in found if exists(header) for name in included_by("include/" + header)} - wanted
    unwanted = [path for path in public_headers() if path[len("include/"):] not in wanted]
    assert not unwanted, "nobody outside the core needs these"


def test_public_headers_are_few():
    assert len(public_headers()) <= MAX_HEADERS
