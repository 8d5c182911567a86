# SPDX-License-Identifier: BSD-3-Clause
"""The command that mapplan.launch runs before its nodes: it writes their parameters, and says what it left out."""

import argparse
import os
import sys
from typing import Any, Optional, Sequence

import yaml

from voxnav.octomap_face.translate import translate


def _loader() -> Any:
    """Returns a loader that takes values with a tag, such as !degrees of MRS, for text: none becomes a parameter."""
    loader: Any = type("Loader", (yaml.SafeLoader,), {})
    loader.add_multi_constructor("!", lambda loader, suffix, node: loader.construct_scalar(node))
    return loader


def _read(path: str) -> Optional[Any]:
    """Returns the content of a YAML file, None without a path. Raises ValueError naming a file that cannot be read."""
    if not path:
        return None
    try:
        with open(path, encoding="utf-8") as source:
            return yaml.load(source, Loader=_loader())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError("%s: %s" % (path, error))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description="Writes the parameters of voxnav that stand for configurations of "
                                                 "mrs_octomap_server, mrs_octomap_planner and mrs_pcl_tools.")
    parser.add_argument("--server", default="", help="YAML file of mrs_octomap_server")
    parser.add_argument("--planner", default="", help="YAML file of mrs_octomap_planner")
    parser.add_argument("--filter", action="append", default=[], metavar="SENSOR=FILE",
                        help="YAML file of the mrs_pcl_tools filter of a sensor")
    parser.add_argument("--sensors", nargs="*", default=[],
                        help="names of all sensors that are launched, in their order")
    parser.add_argument("--out", required=True, help="file that is written")
    return parser


def run(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command and returns its exit status: 0, or 1 after a message that names what is wrong."""
    given = _parser().parse_args(arguments)
    try:
        filters = {name: _read(path) for name, _, path in (each.partition("=") for each in given.filter)}
        done = translate(_read(given.server), _read(given.planner), filters, given.sensors)
    except ValueError as error:
        sys.stderr.write("octomap_config: %s\n" % error)
        return 1
    os.makedirs(os.path.dirname(os.path.abspath(given.out)), exist_ok=True)
    with open(given.out, "w", encoding="utf-8") as out:
        yaml.safe_dump(done.parameters, out, default_flow_style=False)
    for note in done.notes:
        sys.stderr.write("octomap_config: %s\n" % note)
    # The output becomes a parameter, where people can read later what was left out.
    sys.stdout.write("\n".join(done.notes) + "\n")
    return 0


def main() -> None:
    sys.exit(run())
