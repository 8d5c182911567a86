# SPDX-License-Identifier: BSD-3-Clause
"""Every parameter of every node, as the code defines it: {node: {section: [field, ...]}}.

A field is a dict (name, default, min, max, choices, unit, doc).
"""

from __future__ import annotations

import json
import subprocess
from typing import Any, Dict, List

import voxnav
from voxnav.offline.configs import SECTIONS

Parameters = Dict[str, Dict[str, List[Dict[str, Any]]]]

RUNNER = "map_bag"
PYTHON_NODES: Dict[str, Dict[str, Any]] = {
    "planning_manager": {"node": voxnav.PlanningNodeConfig, "manager": voxnav.PlanningManagerConfig,
                         "planner": voxnav.FlightSearchConfig, "map": voxnav.NavigationMapConfig},
    "submap_optimizer": {"node": voxnav.OptimizerConfig, "graph": voxnav.SubmapGraphConfig},
    RUNNER: SECTIONS,
}


def nodelet_parameters(program: str) -> Parameters:
    """Of the nodelets; program: path of the built ``describe_parameters``."""
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


def markdown(parameters: Parameters) -> str:
    """The tables of docs/parameters.md."""
    lines = ["# Parameters", "",
             "Made from the code; do not edit. Every node takes these below its own name, and refuses to start on any "
             "other: unknown keys, wrong types and values out of range are named. Defaults are those of "
             "`config/*.yaml`; put what should differ into a file of your own and give it as `custom_config:=`.", ""]
    for node in sorted(parameters):
        lines += ["## %s" % node, ""]
        for section, fields in parameters[node].items():
            lines += ["### %s/%s" % (node, section), "", "| parameter | default | unit | allowed | meaning |",
                      "|---|---|---|---|---|"]
            lines += ["| `%s` | `%s` | %s | %s | %s |" % (
                f["name"], _value(f["default"]), f["unit"], _range(f), f["doc"].replace("|", "\\|")) for f in fields]
            lines.append("")
    return "\n".join(lines)
