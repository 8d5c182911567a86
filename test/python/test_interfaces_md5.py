# SPDX-License-Identifier: BSD-3-Clause
"""The messages of the vendored interface packages have the md5 sums of the real ones, by which ROS compares them."""
import importlib
import pathlib

import pytest

genmsg = pytest.importorskip("genmsg", reason="genmsg (python3-genmsg) is not installed")
from genmsg import gentools, msg_loader, msgs  # noqa: E402

INTERFACES = pathlib.Path(__file__).resolve().parents[2] / "interfaces"
TABLE = [
    tuple(line.split())
    for line in (pathlib.Path(__file__).parent / "interface_md5.txt").read_text().splitlines()
    if line and not line.startswith("#")
]


def message_text(full_name):
    """Returns the definition from the vendored file, or for messages of ROS from their generated Python class."""
    package, name = full_name.split("/")
    own = INTERFACES / package / "msg" / (name + ".msg")
    if own.exists():
        return own.read_text()
    generated = getattr(importlib.import_module(package + ".msg"), name)
    return generated._full_text.split("\n" + "=" * 80)[0]


def register(context, spec):
    """Registers the messages of which a definition is composed, depth first."""
    for field_type in spec.types:
        name = msgs.bare_msg_type(field_type)
        if not msgs.is_builtin(name) and not context.is_registered(name):
            register(context, msg_loader.load_msg_from_string(context, message_text(name), name))


def md5_of(kind, full_name):
    context = msg_loader.MsgContext.create_default()
    if kind == "msg":
        spec = msg_loader.load_msg_from_string(context, message_text(full_name), full_name)
        register(context, spec)
    else:
        package, name = full_name.split("/")
        folder = INTERFACES.parent if package == "voxnav" else INTERFACES / package
        text = (folder / "srv" / (name + ".srv")).read_text()
        spec = msg_loader.load_srv_from_string(context, text, full_name)
        register(context, spec.request)
        register(context, spec.response)
    return gentools.compute_md5(context, spec)


@pytest.mark.parametrize("kind,full_name,expected", TABLE, ids=[row[1] for row in TABLE])
def test_definition_has_the_md5_of_the_real_package(kind, full_name, expected):
    assert md5_of(kind, full_name) == expected


@pytest.mark.parametrize("package", ["mrs_modules_msgs", "mrs_msgs", "octomap_msgs"])
def test_every_definition_is_in_the_table_and_in_the_package(package):
    cmake = (INTERFACES / package / "CMakeLists.txt").read_text().replace(")", " ").split()
    for kind in ("msg", "srv"):
        on_disk = {path.stem for path in (INTERFACES / package / kind).glob("*." + kind)}
        in_table = {name.split("/")[1] for k, name, _ in TABLE if k == kind and name.startswith(package + "/")}
        in_cmake = {entry[:-4] for entry in cmake if entry.endswith("." + kind)}
        assert on_disk == in_table == in_cmake


@pytest.mark.parametrize("kind,full_name,expected", TABLE, ids=[row[1] for row in TABLE])
def test_generated_classes_in_use_have_the_same_md5(kind, full_name, expected):
    package, name = full_name.split("/")
    module = pytest.importorskip(package + "." + kind, reason=package + " is not built here")
    if "interfaces" not in str(pathlib.Path(module.__file__).resolve()) and not hasattr(module, name):
        pytest.skip("the installed " + package + " has no " + name)
    assert getattr(module, name)._md5sum == expected
