# SPDX-License-Identifier: BSD-3-Clause
"""Public headers include public headers only: what is installed can be compiled without the checkout."""

import os
import re

from test_floors import ROOT, git_files

QUOTED = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
# Internal headers that public ones still include. This list only ever becomes shorter.
STILL_SHOWN = {
    ("include/voxnav/graph/submap_graph.hpp", "graph/pose4.hpp"),
    ("include/voxnav/occupancy/local_map.hpp", "base/worker_pool.hpp"),
    ("include/voxnav/occupancy/local_map.hpp", "occupancy/block_update.hpp"),
    ("include/voxnav/occupancy/local_map.hpp", "occupancy/block_window.hpp"),
    ("include/voxnav/occupancy/local_map.hpp", "occupancy/ray_marks.hpp"),
    ("include/voxnav/odometry/lidar_odometry.hpp", "odometry/imu_buffer.hpp"),
    ("include/voxnav/odometry/lidar_odometry.hpp", "odometry/localizability.hpp"),
    ("include/voxnav/odometry/lidar_odometry.hpp", "odometry/point_map.hpp"),
    ("include/voxnav/odometry/lidar_odometry.hpp", "odometry/registration.hpp"),
    ("include/voxnav/submap/projective_integrator.hpp", "containers/number_table.hpp"),
    ("include/voxnav/submap/scene_changes.hpp", "submap/merged/evidence_map.hpp"),
    ("include/voxnav/submap/submap.hpp", "submap/distance/distance_cache.hpp"),
    ("include/voxnav/submap/submap_collection.hpp", "submap/obstacles/obstacle_map.hpp"),
}


def public_headers():
    return git_files("include/voxnav/*.hpp")


def included_by(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as header:
        return QUOTED.findall(header.read())


def test_public_headers_include_public_headers_only():
    shown = {(path, name) for path in public_headers() for name in included_by(path)
             if not os.path.exists(os.path.join(ROOT, "include", name))}
    assert not sorted(shown - STILL_SHOWN), "internal headers in public ones"
    assert not sorted(STILL_SHOWN - shown), "no longer included: take them off the list"


def test_public_headers_do_not_show_the_libraries_behind_them():
    shown = [(path, name) for path in public_headers()
             for name in re.findall(r"#include <((?:ceres|octomap|yaml-cpp|boost|embree3)/[^>]*)>",
                                    open(os.path.join(ROOT, path), encoding="utf-8").read())]
    assert not shown
