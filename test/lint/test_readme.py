# SPDX-License-Identifier: BSD-3-Clause
"""The example in the README is, letter for letter, the program that test/installed builds and runs."""

import os
import re

from test_floors import ROOT

EXAMPLE = os.path.join("docs", "examples", "map_clouds.cpp")


def read(name):
    with open(os.path.join(ROOT, name), encoding="utf-8") as text:
        return text.read()


def test_the_example_of_the_readme_is_the_one_that_is_built():
    shown = re.findall(r"```cpp\n(.*?)```", read("README.md"), re.DOTALL)
    assert shown == [read(EXAMPLE).split("\n", 1)[1]]  # the README leaves out the line of the licence
