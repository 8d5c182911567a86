# SPDX-License-Identifier: BSD-3-Clause
"""Places fences in the odometry frame, by the transforms of the moment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

import numpy as np

from voxnav._core import FenceContact, FenceKind, Fences, Prism
from voxnav.array_types import Array
from voxnav.fences import utm
from voxnav.fences.book import FenceBook
from voxnav.fences.prisms import LATLON, UTM, FenceError, FencePrism, short_name
from voxnav.fences.world_config import WorldOrigin

WORLD = "world_origin"
# Fences whose corners have moved by less than this are left where they are.
MOVED_M = 0.1


@dataclass(frozen=True, eq=False)
class PlacedFences:
    """Fences in frame O. names: of the zones, in their order; corners: of all prisms, with both heights."""

    fences: Fences
    names: tuple[str, ...]
    corners: Array
    version: int

    def what(self, contact: FenceContact) -> str:
        """Returns a phrase for people about a contact of a place with these fences."""
        if contact.kind == FenceKind.AREA:
            return "outside the safety area"
        return "in the no-fly zone %s" % self.names[contact.zone]

    def is_like(self, other: PlacedFences | None) -> bool:
        """Returns True if the other ones are the same fences at the same place."""
        return (other is not None and other.version == self.version and other.corners.shape == self.corners.shape
                and bool(np.abs(other.corners - self.corners).max(initial=0.0) < MOVED_M))


def place(book: FenceBook, lookup: Callable[[str], Array]) -> PlacedFences:
    """Places the fences of a book. lookup(frame) returns T_O_F (4, 4), or raises FenceError.

    Raises FenceError naming the fence whose frame is not known.
    """
    def placed(prism: FencePrism) -> Prism:
        try:
            return _place_prism(prism, book.world.origin, lookup)
        except FenceError as error:
            raise FenceError("%s: %s" % (prism.name, error))

    area = None if book.area is None else placed(book.area)
    zones = [placed(zone) for zone in book.zones]
    corners = [np.append(prism.outline.ravel(), (prism.min_z, prism.max_z))
               for prism in ([] if area is None else [area]) + zones]
    try:
        fences = Fences(area, zones)
    except ValueError as error:
        raise FenceError(str(error))
    return PlacedFences(fences, tuple(zone.name for zone in book.zones),
                        np.concatenate(corners) if corners else np.zeros(0), book.version)


def _place_prism(prism: FencePrism, origin: WorldOrigin | None, lookup: Callable[[str], Array]) -> Prism:
    points, frame = _in_metres(prism, origin)
    T_O_F = lookup(frame)
    flat = points @ T_O_F[:2, :2].T + T_O_F[:2, 3]
    vertical = UTM if short_name(prism.vertical_frame) == LATLON else prism.vertical_frame
    shift = float(lookup(vertical)[2, 3])
    return Prism(np.ascontiguousarray(flat), prism.min_z + shift, prism.max_z + shift)


def _in_metres(prism: FencePrism, origin: WorldOrigin | None) -> tuple[Array, str]:
    """Returns the corners in metres, and their frame.

    Coordinates of UTM become those of world_origin where its origin is known, since MRS may publish only that frame.
    """
    name = short_name(prism.frame)
    if name not in (LATLON, UTM):
        return prism.points, prism.frame
    points, prefix = prism.points, prism.frame[:-len(name)]
    if name == LATLON:
        points = _utm_of(points, origin)
    if origin is None:
        return points, prefix + UTM
    return points - (origin.east_m, origin.north_m), prefix + WORLD


def _utm_of(points: Array, origin: WorldOrigin | None) -> Array:
    """Converts (n, 2) latitudes and longitudes in the zone of the origin, or of the first point."""
    zone, is_south = utm.zone_of(points[0, 1]), bool(points[0, 0] <= 0.0)
    if origin is not None and origin.zone is not None:
        zone, is_south = origin.zone, origin.is_south
    try:
        return np.array([utm.utm_of(latitude, longitude, zone, is_south) for latitude, longitude in points])
    except ValueError as error:
        raise FenceError(str(error))
