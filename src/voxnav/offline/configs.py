# SPDX-License-Identifier: BSD-3-Clause
"""The configuration of the offline runner, with one YAML section for each part."""

from __future__ import annotations

from typing import Any, Dict

import voxnav

SECTIONS: Dict[str, Any] = {
    "run": voxnav.OfflineConfig,
    "filter": voxnav.CloudFilterConfig,
    "open_beams": voxnav.OpenBeamsConfig,
    "odometry": voxnav.LidarOdometryConfig,
    "mapper": voxnav.MapperConfig,
    "map": voxnav.LocalMapConfig,
    "schedule": voxnav.SubmapSchedulerConfig,
    "submap": voxnav.SubmapConfig,
    "collection": voxnav.SubmapCollectionConfig,
    "graph": voxnav.SubmapGraphConfig,
    "optimizer": voxnav.OptimizerConfig,
}


def load_configs(tree: Any) -> dict[str, Any]:
    """Returns the configuration objects by section, from a dict as YAML gives it.

    Raises voxnav.ConfigError listing every problem of every section; unknown sections are problems too.
    """
    problems: list[str] = []
    configs: dict[str, Any] = {}
    if not isinstance(tree, dict):
        raise voxnav.ConfigError("the configuration must be a mapping of sections")
    for name, config_class in SECTIONS.items():
        values = tree.get(name) or {}
        if not isinstance(values, dict):
            problems.append("%s: is a section and needs parameters below it" % name)
            continue
        try:
            configs[name] = config_class.from_dict(values)
        except voxnav.ConfigError as error:
            problems += ["%s/%s" % (name, line) for line in str(error).splitlines()]
    unknown = [key for key in tree if key not in SECTIONS]
    problems += ["%s: unknown section, known are %s" % (key, ", ".join(SECTIONS)) for key in unknown]
    if problems:
        raise voxnav.ConfigError("\n".join(problems))
    return configs
