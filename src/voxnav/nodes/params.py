# SPDX-License-Identifier: BSD-3-Clause
"""Strict loading of a node's private parameters into the configuration classes of the core."""

import rospy

import voxnav


def load_sections(**sections):
    """Loads every section of the private parameters.

    sections: name = configuration class. Returns the configurations in the order given.
    Raises voxnav.ConfigError listing every problem of every section; keys that belong to no
    section are problems too.
    """
    tree = rospy.get_param("~", {})
    configs, problems = [], []
    for name, config_class in sections.items():
        values = tree.get(name, {})
        if not isinstance(values, dict):
            problems.append("%s: is a section and needs parameters below it" % name)
            continue
        try:
            configs.append(config_class.from_dict(values))
        except voxnav.ConfigError as error:
            problems += ["%s/%s" % (name, line) for line in str(error).splitlines()]
    for key in tree:
        if key not in sections:
            problems.append("%s: unknown section, known are %s" % (key, ", ".join(sections)))
    if problems:
        raise voxnav.ConfigError("\n".join(rospy.get_name() + "/" + problem for problem in problems))
    return configs
