# SPDX-License-Identifier: BSD-3-Clause
"""Translates configurations of mrs_octomap_server, mrs_octomap_planner and mrs_pcl_tools into parameters of voxnav.

Every key either becomes a parameter, or is named in a note that says why it does not: nothing is dropped in silence.
"""

from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

from voxnav.octomap_face.keys import PCL, PLANNER, SERVER, Kept, Rule

Tree = Dict[str, Any]
Path = Tuple[str, ...]
# What mapplan.launch of MRS calls its sensors, in the order of their numbers.
SERVER_FILE, PLANNER_FILE = "config_octomap_server", "config_octomap_planner"
DEPTH_CAMERAS = ("rs_front", "rs_down")
# The period of saving in the configuration of mrs_octomap_server.
SAVE_TIME_S = 10.0
FIRST_LIDAR, LIDAR_KIND, SENSORS = "lidar", "3d_lidar", "sensor_params"
KINDS = ((LIDAR_KIND, (FIRST_LIDAR,)), ("depth_camera", DEPTH_CAMERAS), ("2d_lidar", ("rplidar",)))
# How many of each kind the server uses if its configuration does not say so.
USUAL_NUMBERS = {LIDAR_KIND: 1, "depth_camera": 1, "2d_lidar": 0}


@dataclass
class Translation:
    """Parameters as {node: {section: {name: value}}}, and notes for people."""

    parameters: Tree = field(default_factory=dict)
    left_out: Dict[Tuple[str, str], List[str]] = field(default_factory=dict)  # keys by source and reason

    def set(self, path: str, value: Any) -> None:
        """path: node/section/name"""
        node, section, name = path.split("/")
        self.parameters.setdefault(node, {}).setdefault(section, {})[name] = value

    def note(self, source: str, path: Path, reason: str) -> None:
        self.left_out.setdefault((source, reason), []).append("/".join(path))

    @property
    def notes(self) -> List[str]:
        """One sentence for each reason why keys were left out."""
        return ["%s: %s: %s" % (source, ", ".join(sorted(set(keys))), reason)
                for (source, reason), keys in self.left_out.items()]


def section(source: str, tree: Optional[Tree], *names: str) -> Tree:
    """Returns a part of a tree, {} where there is none. Raises ValueError if something else is in its place."""
    out: Any = tree
    for name in ("",) + names:
        out = (out or {}).get(name) if name else out
        if out is not None and not isinstance(out, dict):
            raise ValueError("%s: %s holds no parameters, but %r" % (source, "/".join(names) or "it", out))
    return out or {}


def leaves(tree: Any, path: Path = ()) -> List[Tuple[Path, Any]]:
    """Returns (path, value) of everything in nested dicts that is no dict."""
    if not isinstance(tree, dict):
        return [(path, tree)]
    return [leaf for key, value in tree.items() for leaf in leaves(value, path + (str(key),))]


def apply(out: Translation, source: str, tree: Optional[Tree], rules: Dict[str, Rule], sensor: str = "") -> None:
    """Applies the rules of one file. sensor: its name takes the place of SENSOR in the names of nodes and sections."""
    for path, value in leaves(section(source, tree)):
        rule = rules.get("/".join(path))
        if rule is None:
            out.note(source, path, "has no counterpart in voxnav")
        elif isinstance(rule, Kept):
            if not rule.is_what_voxnav_does(value):
                out.note(source, path, rule.reason)
        else:
            _set(out, source, path, value, rule.targets, rule.convert, sensor)


def _set(out: Translation, source: str, path: Path, value: Any, targets: Sequence[str],
         convert: Callable[[Any], Any], sensor: str) -> None:
    try:
        converted = convert(value)
    except (TypeError, ValueError, ArithmeticError):
        raise ValueError("%s: %s: %r cannot be used" % (source, "/".join(path), value))
    for target in targets:
        out.set(_named(target, sensor), converted)


def _named(target: str, sensor: str) -> str:
    """Returns the parameter of a sensor. The filter of the first LiDAR bears no name."""
    suffix = "" if sensor in ("", FIRST_LIDAR) else "_" + sensor
    return target.replace("_SENSOR", suffix).replace("SENSOR", sensor)


def sensors_of(tree: Optional[Tree], known: Sequence[str]) -> List[str]:
    """Returns those of the known sensors that a configuration of the server uses.

    n_sensors of each kind leaves out the later ones, which are silent then. The first LiDAR is always used, and so are
    sensors that MRS does not know.
    """
    unused: List[str] = []
    for kind, names in KINDS:
        count = section(SERVER_FILE, tree, SENSORS, kind).get("n_sensors", USUAL_NUMBERS[kind])
        if not isinstance(count, int):
            raise ValueError("%s: n_sensors of %s is %r" % (SERVER_FILE, kind, count))
        unused += names[max(count, 1 if kind == LIDAR_KIND else 0):]
    return [name for name in known if name not in unused]


def _apply_sensors(out: Translation, tree: Optional[Tree]) -> None:
    """Applies the sections of sensors."""
    for kind, names in KINDS:
        left = dict(section(SERVER_FILE, tree, SENSORS, kind))
        left.pop("n_sensors", None)
        for number, name in enumerate(names):
            values = section(SERVER_FILE, left, "sensor_%d" % number)
            left.pop("sensor_%d" % number, None)
            apply(out, SERVER_FILE, {"sensor": values} if values else None, SERVER, name)
        for name in left:
            out.note(SERVER_FILE, (SENSORS, kind, name), "give further sensors as lidars:= or depth_cameras:=")


def _persistency(tree: Optional[Tree]) -> Tree:
    """Returns the tree without save_time if persistency is off, and with its default if it is on."""
    values = dict({"save_time": SAVE_TIME_S}, **section(SERVER_FILE, tree, "persistency"))
    if not values.get("enabled", False):
        del values["save_time"]
    return dict(section(SERVER_FILE, tree), persistency=values)


def heading_mode(planner: Optional[Tree]) -> str:
    """Returns the mode of the section `heading` by the configuration of the planner and its defaults."""
    generator = section(PLANNER_FILE, planner, "trajectory_generator")
    if not generator.get("use_heading", True):
        return "fixed"
    return "flight_direction" if generator.get("turn_in_flight_direction", True) else "goal"


def translate(server: Optional[Tree], planner: Optional[Tree], filters: Dict[str, Optional[Tree]],
              sensors: Sequence[str]) -> Translation:
    """Translates configurations, None where there is none.

    filters: {sensor: configuration of its mrs_pcl_tools/pcl_filter}; sensors: names of all that are launched. Raises
    ValueError naming what cannot be used.
    """
    out = Translation()
    out.set("planning_manager/heading/mode", heading_mode(planner))
    out.set("local_mapper/node/octomap_period_s", 0.05)  # theirs comes with each scan
    _apply_sensors(out, server)
    rest = {name: values for name, values in _persistency(server).items() if name != SENSORS}
    apply(out, SERVER_FILE, rest, SERVER)
    used = sensors_of(server, sensors)
    out.set("local_mapper/node/sensors", used)
    out.set("local_mapper/node/idle_sensors", [name for name in sensors if name not in used])
    apply(out, PLANNER_FILE, planner, PLANNER)
    for sensor, tree in filters.items():
        source = "config_pcl_filter of %s" % sensor
        clip = section(source, tree, "lidar3d", "clip", "range")
        apply(out, source, tree, PCL[_kind(sensor)](bool(clip.get("use", True))), sensor)
    return out


def _kind(sensor: str) -> str:
    return "depth_camera" if sensor in DEPTH_CAMERAS else "lidar"
