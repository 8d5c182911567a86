# SPDX-License-Identifier: BSD-3-Clause
"""The configuration of the offline runner, with one YAML section for each part."""

from __future__ import annotations

from typing import Any, Dict, Sequence

import numpy as np
import yaml

import voxnav
from voxnav.array_types import Array, ArrayLike
from voxnav.demo.mission import repository_file
from voxnav.offline.sensor_configs import SensorConfigs, SensorSections, SensorTopic, put_topics
from voxnav.recordings.plan import BagOptions

SECTIONS: Dict[str, Any] = {
    "run": voxnav.OfflineConfig,
    "filter": voxnav.CloudFilterConfig,
    "pcl": voxnav.PclFiltersConfig,
    "open_beams": voxnav.OpenBeamsConfig,
    "odometry": voxnav.LidarOdometryConfig,
    "mapper": voxnav.MapperConfig,
    "map": voxnav.LocalMapConfig,
    "moving": voxnav.MovingThingsConfig,
    "schedule": voxnav.SubmapSchedulerConfig,
    "submap": voxnav.SubmapConfig,
    "collection": voxnav.SubmapCollectionConfig,
    "graph": voxnav.SubmapGraphConfig,
    "optimizer": voxnav.OptimizerConfig,
}


def load_configs(tree: Any) -> dict[str, Any]:
    """Returns the configuration objects by section, from a dict that was read from YAML.

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
    sensors = SensorSections(tree, configs.get("run") or voxnav.OfflineConfig())
    configs["sensors"], configs["other_sensor"] = sensors.configs(), sensors.common()
    problems += [problem for problem in sensors.problems if problem not in problems]
    known = list(SECTIONS) + sorted(sensors.sections)
    unknown = [key for key in tree if key not in known]
    problems += ["%s: unknown section, known are %s" % (key, ", ".join(known)) for key in unknown]
    if problems:
        raise voxnav.ConfigError("\n".join(problems))
    return configs


def _tree_of(path: str) -> dict[str, Any]:
    """Returns the content of a YAML file. Raises ConfigError naming file and line."""
    with open(path) as source:
        try:
            tree = yaml.safe_load(source) or {}
        except yaml.YAMLError as error:
            raise voxnav.ConfigError("%s: %s" % (path, " ".join(str(error).split())))
    if not isinstance(tree, dict):
        raise voxnav.ConfigError("%s: must be a mapping of sections" % path)
    return tree


def load_files(path: str | None, clouds: Sequence[str] | None = None,
               cameras: Sequence[str] | None = None) -> dict[str, Any]:
    """Returns the configuration of config/map_bag.yaml, in which a file of the user may replace values.

    clouds, cameras: TOPIC or NAME=TOPIC of the sensors that the user gives. Raises ConfigError.
    """
    tree = _tree_of(repository_file("config/map_bag.yaml"))
    for section, values in (_tree_of(path) if path else {}).items():
        tree[section] = dict(tree.get(section) or {}, **(values or {})) if isinstance(values, dict) else values
    put_topics(tree, clouds, cameras)
    return load_configs(tree)


def rotation_from_rpy(rpy_rad: ArrayLike) -> Array:
    """Returns the (3, 3) rotation of fixed-axis roll, pitch, yaw."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy_rad), np.sin(rpy_rad)
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                     [-sp, cp * sr, cp * cr]])


def mount_of(position_m: ArrayLike, rpy_rad: ArrayLike) -> Array:
    """Returns T_B_L (4, 4)."""
    T_B_L = np.eye(4)
    T_B_L[:3, :3] = rotation_from_rpy(np.asarray(rpy_rad, dtype=np.float64))
    T_B_L[:3, 3] = position_m
    return T_B_L


def mount_from_words(text: str) -> Array:
    """Returns T_B_L (4, 4) from 'X Y Z ROLL PITCH YAW' in metres and radians. Raises ValueError."""
    words = text.replace(",", " ").split()
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) != 6 or not np.all(np.isfinite(values)):
        raise ValueError("--mount needs six numbers X Y Z ROLL PITCH YAW (metres and radians), not '%s'" % text)
    return mount_of(values[:3], values[3:])


def given_mount(words: str | None, settings: Any) -> Array | None:
    """Returns the mount T_B_L (4, 4) that the user gives, or None to take it from the recording. words: of --mount."""
    if words:
        return mount_from_words(words)
    source = settings.mount_source
    is_set = bool(np.any(settings.mount_position_m) or np.any(settings.mount_rpy_rad))
    if source == voxnav.MountSource.GIVEN or (source == voxnav.MountSource.AUTO and is_set):
        return mount_of(settings.mount_position_m, settings.mount_rpy_rad)
    return None


def options_of(configs: dict[str, Any], T_B_L: Array | None) -> BagOptions:
    """Returns the options for reading a bag."""
    settings = configs["run"]
    cameras = [SensorTopic.of(text).topic for text in settings.depth_camera_topics]
    return BagOptions(
        SensorTopic.of(settings.cloud_topic).topic, settings.odometry_topic, settings.imu_topic, T_B_L,
        settings.pose_source, configs["odometry"].use_imu, configs["mapper"].max_pose_gap_s,
        further_cloud_topics=tuple(SensorTopic.of(text).topic for text in settings.further_cloud_topics),
        depth_cameras=tuple((topic, configs["sensors"][topic.lstrip("/")].depth) for topic in cameras),
        odometry_frame=settings.odometry_frame)


def sensor_configs(configs: dict[str, Any], topic: str) -> SensorConfigs:
    """Returns the configuration of the sensor on a topic."""
    found: SensorConfigs = configs["sensors"].get(topic.lstrip("/"), configs["other_sensor"])
    return found
