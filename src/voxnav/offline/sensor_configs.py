# SPDX-License-Identifier: BSD-3-Clause
"""The configuration of each sensor of a recording, in the sections that the nodes of the same sensor have."""

from __future__ import annotations

from typing import Any, Dict, List, NamedTuple, Sequence

import yaml

import voxnav
from voxnav.demo.mission import repository_file

FILTER_PARTS: Dict[str, Any] = {"filter": voxnav.CloudFilterConfig, "pcl": voxnav.PclFiltersConfig,
                                "open_beams": voxnav.OpenBeamsConfig}
DEPTH_PARTS: Dict[str, Any] = {"depth": voxnav.DepthCloudConfig}


class SensorTopic(NamedTuple):
    """A sensor as people name it, NAME=TOPIC or TOPIC. name: empty if it has none, and so no sections of its own."""

    name: str
    topic: str

    @staticmethod
    def of(text: str) -> SensorTopic:
        name, _, topic = text.rpartition("=")
        return SensorTopic(name.strip(), topic.strip())


class SensorConfigs(NamedTuple):
    """The parts that process the clouds of one sensor. limits: its ranges and rate in the map."""

    filter: Any
    pcl: Any
    open_beams: Any
    limits: Any
    depth: Any


class SensorSections:
    """The sections ``cloud_filter_NAME``, ``depth_cloud_NAME`` and ``local_mapper/NAME`` of a configuration.

    problems: what is wrong with them. sections: the names of all sections that belong to sensors.
    """

    def __init__(self, tree: dict[str, Any], settings: Any) -> None:
        self.problems: List[str] = []
        self._tree = tree
        lidars = [settings.cloud_topic] + list(settings.further_cloud_topics)
        self._kinds = [(SensorTopic.of(text), False) for text in lidars if text]
        self._kinds += [(SensorTopic.of(text), True) for text in settings.depth_camera_topics]
        names = [sensor.name for sensor, _ in self._kinds if sensor.name]
        self.problems += ["two sensors are called %s" % name for name in sorted(set(names)) if names.count(name) > 1]
        self.sections = {"cloud_filter_" + name for name in names}
        self.sections |= {"depth_cloud_" + sensor.name for sensor, is_camera in self._kinds
                          if is_camera and sensor.name}
        if names:
            self.sections.add("local_mapper")
            self.problems += ["local_mapper/%s: no sensor of that name; named are %s" % (key, ", ".join(names))
                              for key in self._values(self._tree, "local_mapper") if key not in names]

    def configs(self) -> dict[str, SensorConfigs]:
        """Returns the configurations by topic, without its leading slash. What is not set for a sensor is as the
        sections ``filter``, ``pcl`` and ``open_beams`` say for all of them."""
        return {sensor.topic.lstrip("/"): self._of(sensor.name, is_camera) for sensor, is_camera in self._kinds}

    def common(self) -> SensorConfigs:
        """Returns the configuration of a sensor that is not named."""
        return self._of("", is_camera=False)

    def _of(self, name: str, is_camera: bool) -> SensorConfigs:
        section = "cloud_filter_" + name
        own = self._values(self._tree, section) if name else {}
        self._refuse_unknown(own, FILTER_PARTS, section)
        parts = {part: self._made(config_class, dict(self._values(self._tree, part),
                                                     **self._values(own, part, section)),
                                  "%s/%s" % (section, part) if name else part)
                 for part, config_class in FILTER_PARTS.items()}
        limits = _depth_camera_limits() if is_camera else {}
        mapper = self._values(self._tree, "local_mapper") if name else {}
        limits = dict(limits, **self._values(mapper, name, "local_mapper"))
        depth = self._values(self._tree, "depth_cloud_" + name) if name and is_camera else {}
        self._refuse_unknown(depth, DEPTH_PARTS, "depth_cloud_" + name)
        depth = self._values(depth, "depth", "depth_cloud_" + name)
        return SensorConfigs(limits=self._made(voxnav.SensorConfig, limits, "local_mapper/" + name),
                             depth=self._made(voxnav.DepthCloudConfig, depth, "depth_cloud_%s/depth" % name), **parts)

    def _refuse_unknown(self, values: dict[str, Any], known: dict[str, Any], section: str) -> None:
        self.problems += ["%s/%s: unknown section, known are %s" % (section, key, ", ".join(known))
                          for key in values if key not in known]

    def _made(self, config_class: Any, values: dict[str, Any], section: str) -> Any:
        try:
            return config_class.from_dict(values)
        except voxnav.ConfigError as error:
            self.problems += ["%s/%s" % (section, line) for line in str(error).splitlines()]
            return config_class()

    def _values(self, tree: dict[str, Any], key: str, section: str = "") -> dict[str, Any]:
        """Returns a section below another one, which is empty if it is missing."""
        values = tree.get(key) or {}
        if isinstance(values, dict):
            return values
        text = "%s: is a section and needs parameters below it" % (section + "/" + key if section else key)
        if text not in self.problems:
            self.problems.append(text)
        return {}


def _depth_camera_limits() -> dict[str, Any]:
    with open(repository_file("config/sensors/depth_camera.yaml")) as source:
        limits: dict[str, Any] = yaml.safe_load(source)
    return limits


def put_topics(tree: dict[str, Any], clouds: Sequence[str] | None, cameras: Sequence[str] | None) -> None:
    """Puts the sensors that somebody gives into the section ``run``, the LiDAR first. None leaves what is there."""
    run = dict(tree.get("run") or {})
    if clouds:
        run["cloud_topic"], run["further_cloud_topics"] = clouds[0], list(clouds[1:])
    if cameras:
        run["depth_camera_topics"] = list(cameras)
    tree["run"] = run
