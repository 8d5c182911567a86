# SPDX-License-Identifier: BSD-3-Clause
"""What the demonstration asks of the UAV: take off, cross the world, arrive at its goal."""

import os

import numpy as np
import yaml


def repository_file(name):
    """Path of a file of this repository (development checkout or installed package)."""
    here = os.path.dirname(os.path.abspath(__file__))
    for root in (os.path.join(here, "..", "..", ".."), _package_path()):
        if root and os.path.exists(os.path.join(root, name)):
            return os.path.abspath(os.path.join(root, name))
    raise FileNotFoundError(name)


def _package_path():
    try:
        import rospkg

        return rospkg.RosPack().get_path("voxnav")
    except Exception:  # without ROS there is no package path; the checkout is tried alone
        return None


def world_settings(world):
    """The world's YAML as a dict."""
    with open(repository_file("worlds/%s.yaml" % world)) as source:
        return yaml.safe_load(source)


def goal_of(world, flight_height_m=2.0):
    """Goal (3,) in the world's frame: the clear spot behind the trees, at flight height."""
    x, y = world_settings(world)["goal_m"]
    return np.array([x, y, flight_height_m])


def _circles(stems):
    return np.column_stack([stems.ground[:, :2], stems.radius_ground_m])


def trunks(world, seed):
    """(n, 3) x y radius of the trunks and poles as generated, or None where the simulator is not built."""
    try:
        from voxnav import simulation
    except ImportError:
        return None
    world = simulation.World(repository_file("worlds/%s.yaml" % world), seed=seed)
    return np.vstack([_circles(world.trunks()), _circles(world.poles())])
