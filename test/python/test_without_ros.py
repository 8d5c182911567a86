# SPDX-License-Identifier: BSD-3-Clause
"""The Python package of a build without ROS, which consists of links to the checkout, maps a folder of raw scans."""

import os
import re
import subprocess
import sys

import numpy as np

import voxnav

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SOURCE = os.path.join(ROOT, "src", "voxnav")


def linked_package(folder):
    """Makes the links that src/bindings/CMakeLists.txt makes, with the C++ module of this environment."""
    with open(os.path.join(ROOT, "src", "bindings", "CMakeLists.txt")) as text:
        folders = re.search(r"foreach\(entry \$\{python_files\} ([\w ]+)\)", text.read()).group(1).split()
    (folder / "voxnav").mkdir()
    modules = [name for name in os.listdir(SOURCE) if name.endswith(".py")]
    for name in modules + folders:
        os.symlink(os.path.join(SOURCE, name), str(folder / "voxnav" / name))
    module = sys.modules[voxnav.LocalMap.__module__].__file__
    os.symlink(module, str(folder / "voxnav" / os.path.basename(module)))
    return str(folder)


def test_raw_scans_are_mapped_by_the_package_of_a_build_without_ros(tmp_path):
    (tmp_path / "package").mkdir()
    package = linked_package(tmp_path / "package")
    scans = tmp_path / "recording" / "scans"
    scans.mkdir(parents=True)
    angles = np.linspace(-np.pi, np.pi, 2000, endpoint=False)
    heights = np.repeat([-1.0, 0.0, 1.0, 2.0], 2000)
    room = np.column_stack([np.tile(8.0 * np.cos(angles), 4), np.tile(6.0 * np.sin(angles), 4), heights,
                            np.full(8000, 100.0)]).astype("<f4")
    for i in range(3):
        room.tofile(str(scans / ("%06d.bin" % i)))
    poses = tmp_path / "poses.txt"
    poses.write_text("".join("%.1f 0 0 0 0 0 0 1\n" % (0.1 * i) for i in range(3)))
    (tmp_path / "recording" / "times.txt").write_text("0.0\n0.1\n0.2\n")
    # Only the links are on the path, so that no part of a workspace is found.
    environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": package, "HOME": str(tmp_path),
                   "LD_LIBRARY_PATH": os.environ.get("LD_LIBRARY_PATH", "")}
    done = subprocess.run(
        [sys.executable, os.path.join(ROOT, "scripts", "map_bag"), "--scans", str(tmp_path / "recording"), "--poses",
         str(poses), "--out", str(tmp_path / "out")], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        universal_newlines=True, timeout=120, cwd=str(tmp_path))
    assert done.returncode == 0 and "3 of 3 scans were mapped" in done.stdout, done.stdout
