# SPDX-License-Identifier: BSD-3-Clause
"""No decision of the sources compares text: kinds are enums, and text is for people (docs/architecture.md)."""

import ast
import os
import re
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

# The literals that may be compared, by file: there the text itself is read, as in file formats, field names, command
# lines, and names of nodes and scenarios. Comparing with the empty string is allowed everywhere.
ALLOWED = {
    "src/core/cloud/point_times.cpp": {"t"},
    "src/ros/local_mapper_watch.cpp": {"beam_x"},
    "src/ros/param_loader.cpp": {"_"},
    "src/simulation/world/flat_yaml.cpp": {"true", "false", "!"},
    "src/voxnav/alignment/cli.py": {"long"},
    "src/voxnav/alignment/ghosts.py": {"corrected"},
    "src/voxnav/nodes/flight_recorder.py": {"uav_simulator"},
    "src/voxnav/nodes/mapping_mission.py": {"local_mapper"},
}

CPP_COMPARISON = re.compile(r'[=!]=\s*"((?:[^"\\]|\\.)*)"|"((?:[^"\\]|\\.)*)"\s*[=!]=|\.compare\(\s*"((?:[^"\\]|\\.)*)"'
                            r'|str(?:n?case)?n?cmp\([^;]*"((?:[^"\\]|\\.)*)"')


def git_files(*patterns):
    out = subprocess.check_output(["git", "ls-files"] + list(patterns), cwd=ROOT, universal_newlines=True)
    return [name for name in out.splitlines() if os.path.exists(os.path.join(ROOT, name))]


def cpp_comparisons(text):
    """Returns line and literal of every comparison with text."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        code = line.split("//")[0] if line.lstrip().startswith("//") else line
        for groups in CPP_COMPARISON.findall(code):
            found.append((number, next((group for group in groups if group), "")))
    return found


def _texts(node):
    """Returns the text constants of an expression that is one, or a tuple, list or set of them."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return [node.value]
    if isinstance(node, (ast.Tuple, ast.List, ast.Set)):
        return [text for item in node.elts for text in _texts(item)]
    return []


def python_comparisons(text):
    """Returns line and literal of every ==, != or `in` with text constants, and of calls like reason.startswith()."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Compare):
            sides = [node.left] + node.comparators
            for operator, left, right in zip(node.ops, sides, sides[1:]):
                compared = []
                if isinstance(operator, (ast.Eq, ast.NotEq)):
                    compared = _texts(left) + _texts(right)
                elif isinstance(operator, (ast.In, ast.NotIn)) and not isinstance(left, ast.Constant):
                    compared = _texts(right)
                found += [(node.lineno, literal) for literal in compared]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            words = re.compile(r"reason|status|state|kind|mode|policy")
            if node.func.attr in ("startswith", "endswith") and words.search(ast.dump(node.func.value)):
                found += [(node.lineno, literal) for argument in node.args for literal in _texts(argument)]
    return found


def forbidden(path, comparisons):
    return ["%s:%d compares with '%s'" % (path, line, literal) for line, literal in comparisons
            if literal and literal not in ALLOWED.get(path, ())]


def _read(path):
    with open(os.path.join(ROOT, path)) as source:
        return source.read()


def test_the_check_finds_comparisons():
    assert cpp_comparisons('if (reason == "first scan") extend();') == [(1, "first scan")]
    assert cpp_comparisons('is_full = "full" != mode;\n// x == "y"\nif (std::strcmp(a, "b") == 0) {}') == [
        (1, "full"), (3, "b")]
    assert cpp_comparisons('EXPECT(x == y); out += "a = \\"b\\"";') == []
    assert python_comparisons("if a.kind == 'hover':\n    pass") == [(1, "hover")]
    assert python_comparisons("x = [k for k in a if k in ('b', 'c')]") == [(1, "b"), (1, "c")]
    assert python_comparisons("is_up = status['reason'].startswith(('hover', 'brake'))") == [(1, "hover"), (1, "brake")]
    assert python_comparisons("if 'key' in table or name.startswith('/'):\n    pass") == []


def test_no_decision_of_cpp_compares_text():
    broken = []
    for path in git_files("include/*.hpp", "src/*.hpp", "src/*.cpp"):
        broken += forbidden(path, cpp_comparisons(_read(path)))
    assert not broken, "\n".join(broken)


def test_no_decision_of_python_compares_text():
    broken = []
    for path in git_files("src/*.py"):
        broken += forbidden(path, python_comparisons(_read(path)))
    assert not broken, "\n".join(broken)
