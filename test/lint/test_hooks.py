# SPDX-License-Identifier: BSD-3-Clause
"""The hooks of .pre-commit-config.yaml download nothing, and check what `make lint` checks."""

import os
import re

import yaml

from test_floors import ROOT


def read(name):
    with open(os.path.join(ROOT, name)) as source:
        return source.read()


def hooks():
    repositories = yaml.safe_load(read(".pre-commit-config.yaml"))["repos"]
    return [hook for repository in repositories for hook in repository["hooks"]]


def test_hooks_come_from_this_machine():
    assert [repository["repo"] for repository in yaml.safe_load(read(".pre-commit-config.yaml"))["repos"]] == ["local"]
    assert {hook["language"] for hook in hooks()} == {"system"}


def test_hooks_are_stages_of_lint():
    lint = read("scripts/dev/run_lint")
    by_name = {hook["id"]: hook["entry"] for hook in hooks()}
    assert set(by_name) == {"clang-format", "flake8", "lint"}
    assert "clang-format" in lint
    for name in ("flake8", "lint"):
        options = re.search(r"-m .*", by_name[name]).group()
        assert options in lint, "%s: %s is not what scripts/dev/run_lint runs" % (name, options)
