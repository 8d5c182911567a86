# SPDX-License-Identifier: BSD-3-Clause
"""The stubs of the C++ modules hold every public name with the same arguments, and no other name."""

import ast
import importlib.util
import inspect
import os
from importlib.machinery import SourceFileLoader

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
MODULES = ("_core", "_simulation")
MAKER = os.path.join(ROOT, "scripts", "dev", "make_stubs")
SPECIAL = ("__init__", "__len__", "__call__", "__iter__", "__contains__")


def maker():
    loader = SourceFileLoader("make_stubs", MAKER)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("make_stubs", loader))
    loader.exec_module(module)
    return module


def parsed(name):
    """Returns {name of a class or None: {name: arguments or None}} of the stub of a module."""
    with open(os.path.join(ROOT, "src", "voxnav", name + ".pyi")) as source:
        tree = ast.parse(source.read())
    found = {None: members_of(tree.body)}
    found.update({node.name: members_of(node.body) for node in tree.body if isinstance(node, ast.ClassDef)})
    return found


def members_of(body):
    out = {}
    for node in body:
        if isinstance(node, ast.FunctionDef):
            decorators = " ".join(ast.dump(each) for each in node.decorator_list)
            if "property" in decorators or "setter" in decorators:
                out[node.name] = None
            else:
                names = [each.arg for each in node.args.args + node.args.kwonlyargs]
                out.setdefault(node.name, []).append(names)
        elif isinstance(node, ast.ClassDef):
            out[node.name] = None
        elif isinstance(node, ast.AnnAssign):
            out[node.target.id] = None
        elif isinstance(node, ast.Assign):  # a member of an enum
            out[node.targets[0].id] = None
    return out


def import_or_skip(name):
    if name == "_simulation":
        pytest.importorskip("voxnav._simulation", reason="the simulation is not built: no Embree")
    return importlib.import_module("voxnav." + name)


@pytest.mark.parametrize("name", MODULES)
def test_stubs_name_what_is_public_and_nothing_else(name):
    module = import_or_skip(name)
    missing = set(maker().public_names(module)) ^ set(parsed(name)[None])
    assert not missing, "run scripts/dev/make_stubs: %s" % sorted(missing)


@pytest.mark.parametrize("name", MODULES)
def test_stubs_name_the_members_of_every_class(name):
    module, stubs = import_or_skip(name), parsed(name)
    for class_name in [each for each in stubs if each is not None]:
        cls = getattr(module, class_name)
        public = {each for each in vars(cls) if not each.startswith("_")}
        stubbed = {each for each in stubs[class_name] if not each.startswith("_")}
        assert public == stubbed, "run scripts/dev/make_stubs: %s differs by %s" % (class_name, public ^ stubbed)


@pytest.mark.parametrize("name", MODULES)
def test_stubs_name_the_arguments_of_every_function(name):
    module, stubs, make = import_or_skip(name), parsed(name), maker()
    num_compared = 0
    for class_name, members in stubs.items():
        owner = module if class_name is None else getattr(module, class_name)
        for member, stubbed in members.items():
            is_config = member == "__init__" and hasattr(owner, "describe")
            if stubbed is None or (member.startswith("_") and member not in SPECIAL):
                continue
            if is_config:
                assert stubbed == [["self"] + [field["name"] for field in owner.describe()]], class_name
                continue
            function = inspect.getattr_static(owner, member) if class_name else getattr(owner, member)
            function = getattr(owner, member) if isinstance(function, staticmethod) else function
            names = [[each.split(":")[0].split("=")[0].strip() for each in arguments]
                     for arguments, _ in make.signatures(function)]
            names = [[each for each in row if not each.startswith("*")] for row in names]
            assert names == stubbed, "run scripts/dev/make_stubs: %s.%s" % (class_name, member)
            num_compared += 1
    assert num_compared > 20
