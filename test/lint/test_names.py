# SPDX-License-Identifier: BSD-3-Clause
"""One name stands for one thing: no two types have the same name, and no message and type that differ have."""

import ast
import os
import re
from collections import defaultdict

from test_floors import ROOT, git_files

# A type at the level of a namespace. Types within a class are left out, because the class tells them apart.
TYPE = re.compile(r"^(?:template <[^>]*>\s*)?(?:class|struct|enum class|enum) (\w+)(?: final)?\s*(?::(?!:)[^;{]*)?\{"
                  r"|^using (\w+) =", re.MULTILINE)
COMMENT = re.compile(r"//.*")
# The messages that are a type of the core on its way to another node; docs/terminology.md has the rule.
SENT_AS_THEY_ARE = {"GridUpdate", "Handover", "MovingThing", "OtherUav", "SceneChange"}
# Python classes with the name of a C++ class that they wrap or correspond to.
IN_BOTH_LANGUAGES = {"Diagnostics", "World"}
# The one header that names the generated messages, which ROS 1 puts into the namespace voxnav.
MESSAGES_HEADER = "include/voxnav_ros/messages.hpp"


def text_of(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as source:
        return source.read()


def types_in(*patterns):
    """Returns {name: the files that define a type of this name}."""
    found = defaultdict(set)
    for path in git_files(*patterns):
        for names in TYPE.findall(COMMENT.sub("", text_of(path))):
            found["".join(names)].add(path)
    return found


def python_classes():
    found = defaultdict(set)
    for path in git_files("src/voxnav/*.py"):
        for node in ast.walk(ast.parse(text_of(path))):
            if isinstance(node, ast.ClassDef):
                found[node.name].add(path)
    return found


def messages():
    return {os.path.basename(path)[:-len(".msg")] for path in git_files("msg/*.msg")}


def shared(names):
    return {name: sorted(files) for name, files in names.items() if len(files) > 1}


def test_the_patterns_find_types():
    types = types_in("include/*.hpp", "src/*.hpp")
    assert {"Submap", "VoxelState", "PointsView", "GridUpdate", "PlanStatus"} <= set(types)
    assert types["Submap"] == {"include/voxnav/submap/submap.hpp"}
    assert "FinishedSubmap" in messages() and "SubmapRecord" in python_classes()


def test_no_two_headers_define_types_of_one_name():
    assert not shared(types_in("include/*.hpp", "src/*.hpp"))


def test_no_source_defines_a_type_with_the_name_of_a_type_in_a_header():
    headers, sources = types_in("include/*.hpp", "src/*.hpp"), types_in("src/*.cpp")
    assert not {name: sorted(sources[name] | headers[name]) for name in sources if name in headers}


def test_no_two_python_classes_have_one_name():
    assert not shared(python_classes())


def test_python_and_cpp_classes_share_names_only_where_they_correspond():
    assert set(types_in("include/*.hpp", "src/*.hpp")) & set(python_classes()) == IN_BOTH_LANGUAGES


def test_messages_share_names_only_with_the_types_that_they_send():
    named = set(types_in("include/*.hpp", "src/*.hpp")) | set(python_classes())
    assert messages() & named == SENT_AS_THEY_ARE
    for name in SENT_AS_THEY_ARE:
        assert re.search(r"^\| %s \|" % name, text_of("docs/terminology.md"), re.MULTILINE), name


def test_cpp_names_messages_in_the_namespace_msg():
    message = re.compile(r"\bvoxnav::(?:%s)(?:ConstPtr|Ptr)?\b(?!::k)" % "|".join(sorted(messages())))
    found = [(path, name) for path in git_files("include/voxnav_ros/*.hpp", "src/ros/*.?pp", "test/unit/ros/*.cpp")
             if path != MESSAGES_HEADER for name in message.findall(COMMENT.sub("", text_of(path)))]
    assert not found, "write msg:: (%s)" % MESSAGES_HEADER
