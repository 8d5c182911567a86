# SPDX-License-Identifier: BSD-3-Clause
"""The worlds of a campaign: files of worlds/, with another number of trees per hectare."""

from __future__ import annotations

import os
from typing import NamedTuple

import yaml

from voxnav.campaign.errors import CampaignError
from voxnav.demo.mission import world_file


class WorldText(NamedTuple):
    """A world: name (of its file, without .yaml), the file's text, and its trees per hectare."""

    name: str
    text: str
    trees_per_ha: float


def read_world(name_or_path: str) -> WorldText:
    """Reads a world, given by the name of a file in worlds/ or by a path that ends in .yaml. Raises CampaignError."""
    try:
        path = world_file(name_or_path)
        with open(path) as source:
            text = source.read()
    except OSError as error:
        raise CampaignError("there is no world %s: %s" % (name_or_path, error)) from error
    name = os.path.splitext(os.path.basename(path))[0]
    try:
        fields = yaml.safe_load(text)
        return WorldText(name, text, float(fields["trees_per_ha"]))
    except (yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        raise CampaignError("%s is no file of a world with trees_per_ha: %r" % (path, error)) from error


def with_density(world: WorldText, trees_per_ha: float | None) -> WorldText:
    """Returns the world with another density; None keeps its own. Raises CampaignError if such a world cannot be."""
    if trees_per_ha is None or trees_per_ha == world.trees_per_ha:
        return world
    fields = dict(yaml.safe_load(world.text), trees_per_ha=float(trees_per_ha))
    _check(world.name, fields)
    text = "# This is the world %s with another density.\n%s" % (
        world.name, yaml.safe_dump(fields, default_flow_style=None, sort_keys=False))
    return WorldText(world.name, text, float(trees_per_ha))


def _check(name: str, fields: dict[str, object]) -> None:
    try:
        from voxnav import simulation
    except ImportError:
        return  # without Embree nothing flies here; the machines that fly check the world themselves
    try:
        simulation.WorldConfig.from_dict(fields)
    except ValueError as error:
        raise CampaignError("world %s: %s" % (name, error)) from error
