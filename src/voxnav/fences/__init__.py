# SPDX-License-Identifier: BSD-3-Clause
"""Fences of a flight: the safety area of an MRS world configuration, and no-fly zones, in any frame of the vehicle.

A fence is read as an upright prism in the frames that its file or message names (``prisms``), from a world
configuration (``world_config``) or one by one (``FenceBook``), and placed in the odometry frame by the transforms of
the moment (``placing``). What is made of them there, ``voxnav.Fences``, is exact geometry of the C++ core.
"""

from voxnav.fences.book import FenceBook, Limits
from voxnav.fences.placing import PlacedFences, place
from voxnav.fences.prisms import FencePrism, FenceError, read_prism, virtual_obstacle
from voxnav.fences.world_config import WorldFences, WorldOrigin, read_world_config

__all__ = ["FenceBook", "FenceError", "FencePrism", "Limits", "PlacedFences", "WorldFences", "WorldOrigin", "place",
           "read_prism", "read_world_config", "virtual_obstacle"]
