# SPDX-License-Identifier: BSD-3-Clause
"""Every parameter of every node, as the code defines it: {node: {section: [field, ...]}}.

A field is a dict (name, default, min, max, choices, unit, doc).
"""

from __future__ import annotations

import json
import os
import subprocess
from typing import Any, Dict, List

import voxnav
from voxnav.offline.configs import SECTIONS

Parameters = Dict[str, Dict[str, List[Dict[str, Any]]]]

RUNNER = "map_bag"
PYTHON_NODES: Dict[str, Dict[str, Any]] = {
    "planning_manager": {"node": voxnav.PlanningNodeConfig, "manager": voxnav.PlanningManagerConfig,
                         "planner": voxnav.FlightSearchConfig, "map": voxnav.NavigationMapConfig,
                         "fences": voxnav.FencesConfig, "home": voxnav.HomeConfig, "heading": voxnav.HeadingConfig,
                         "others": voxnav.OtherUavsConfig,
                         "work": voxnav.WorkTimeConfig, "time": voxnav.TimeConfig},
    "octomap_server": {"node": voxnav.OctomapServerConfig},
    "octomap_planner": {"node": voxnav.OctomapPlannerConfig},
    "bumper": {"node": voxnav.BumperNodeConfig, "sectors": voxnav.ObstacleSectorsConfig},
    "submap_optimizer": {"node": voxnav.OptimizerConfig, "graph": voxnav.SubmapGraphConfig,
                         "time": voxnav.TimeConfig},
    RUNNER: SECTIONS,
}

# The parameters that are changed most often, as node/section/name: sensor and mount, detail and reach of the map,
# distances, limits.
OFTEN_CHANGED = (
    "cloud_filter/filter/body_radius_m", "cloud_filter/filter/min_range_m", "cloud_filter/filter/ghost_intensity",
    "cloud_filter/filter/row_decimation",
    "local_mapper/map/resolution_m", "local_mapper/map/window_size_m", "local_mapper/map/max_range_m",
    "local_mapper/map/no_return_range_m", "local_mapper/map/num_threads", "local_mapper/submap/period_s",
    "submap_integrator/node/safety_distance_m", "submap_integrator/node/autosave_dir",
    "submap_integrator/collection/max_memory_mb", "submap_optimizer/node/gnss_type",
    "planning_manager/planner/safety_distance_m", "planning_manager/planner/unknown_policy",
    "planning_manager/manager/corridor_radius_m", "planning_manager/manager/max_flight_time_s",
    "planning_manager/map/min_altitude_m", "planning_manager/map/max_altitude_m",
)


def describing_program() -> str | None:
    """Returns the path of ``describe_parameters`` in the workspace of this environment, or None if it is not built."""
    paths = [os.path.join(prefix, "lib", "voxnav", "describe_parameters")
             for prefix in os.environ.get("CMAKE_PREFIX_PATH", "").split(":")]
    return next((path for path in paths if os.path.exists(path)), None)


def nodelet_parameters(program: str) -> Parameters:
    """Returns the parameters of the nodelets. program: path of the built ``describe_parameters``."""
    parameters: Parameters = json.loads(subprocess.check_output([program], timeout=60).decode())
    return parameters


def python_parameters() -> Parameters:
    return {node: {name: config.describe() for name, config in sections.items()}
            for node, sections in PYTHON_NODES.items()}


def _range(field: dict[str, Any]) -> str:
    if field["choices"]:
        return ", ".join("`%s`" % (choice or "(empty)") for choice in field["choices"])
    low, high = field["min"], field["max"]
    is_number = isinstance(field["default"], (int, float, list)) and not isinstance(field["default"], bool)
    is_bounded = is_number and low is not None and high is not None and abs(low) < 1e300 and abs(high) < 1e300
    return "%g to %g" % (low, high) if is_bounded else ""


def _value(value: Any) -> str:
    return json.dumps(value) if value != "" else '""'


def _row(name: str, field: dict[str, Any]) -> str:
    return "| `%s` | `%s` | %s | %s | %s |" % (
        name, _value(field["default"]), field["unit"], _range(field), field["doc"].replace("|", "\\|"))


def _often_changed(parameters: Parameters) -> list[str]:
    """Returns the rows of the first table. Raises KeyError naming a parameter of the list that does not exist."""
    rows = []
    for path in OFTEN_CHANGED:
        node, section, name = path.split("/")
        fields = {field["name"]: field for field in parameters[node][section]}
        if name not in fields:
            raise KeyError("voxnav.parameters.OFTEN_CHANGED: there is no %s" % path)
        rows.append(_row(path, fields[name]))
    return rows


_HEADER = ["| parameter | default | unit | allowed | meaning |", "|---|---|---|---|---|"]


def markdown(parameters: Parameters) -> str:
    """Returns the tables of docs/parameters.md."""
    lines = ["# Parameters", "",
             "This page is made from the code by `scripts/dev/make_parameter_docs`. A node takes the parameters below "
             "its own name and refuses to start on any other: it names unknown keys, wrong types and values out of "
             "range. The defaults are those of `config/*.yaml`; put what should differ into a file of your own and "
             "give it as `custom_config:=`.", "", "## What people change", ""]
    lines += _HEADER + _often_changed(parameters) + [""]
    for node in sorted(parameters):
        lines += ["## %s" % node, ""]
        for section, fields in parameters[node].items():
            lines += ["### %s/%s" % (node, section), ""] + _HEADER
            lines += [_row(field["name"], field) for field in fields]
            lines.append("")
    return "\n".join(lines)
