# SPDX-License-Identifier: BSD-3-Clause
"""The mission of the demonstration: the UAV takes off, crosses the world and arrives at its goal."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from voxnav.array_types import Array

if TYPE_CHECKING:
    from voxnav.simulation import Stems, World  # needs Embree


def repository_file(name: str) -> str:
    """Returns the path of a file of this repository, in the development checkout or the installed package."""
    here = os.path.dirname(os.path.realpath(__file__))  # a build without ROS links to the checkout
    for root in (os.path.join(here, "..", "..", ".."), _package_path()):
        if root and os.path.exists(os.path.join(root, name)):
            return os.path.abspath(os.path.join(root, name))
    raise FileNotFoundError(name)


def _package_path() -> str | None:
    try:
        import rospkg

        return str(rospkg.RosPack().get_path("voxnav"))
    except Exception:  # without ROS there is no package path; the checkout is tried alone
        return None


def world_file(world: str) -> str:
    """Returns the path of a world, which is given by the name of a file in worlds/ or by a path that ends in .yaml."""
    return os.path.abspath(world) if world.endswith(".yaml") else repository_file("worlds/%s.yaml" % world)


def simulated_world(world: str, seed: int) -> World:
    """Generates the same world as the simulator, without ROS."""
    from voxnav import simulation

    return simulation.World(world_file(world), seed=seed)


def goal_of(world: World, flight_height_m: float = 2.0) -> Array:
    """Returns the goal (3,) in W: the clear spot behind the trees, at flight height above its ground.

    world: voxnav.simulation.World.
    """
    x, y = world.config.goal_m
    return np.array([x, y, world.ground_height(x, y) + flight_height_m])


def _circles(stems: Stems) -> Array:
    return np.column_stack([stems.ground[:, :2], stems.radius_ground_m])


def trunks(world: World) -> Array:
    """Returns (n, 3) x y radius of the trunks and poles as generated. world: voxnav.simulation.World."""
    return np.vstack([_circles(world.trunks()), _circles(world.poles())])
