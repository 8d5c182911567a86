# SPDX-License-Identifier: BSD-3-Clause
"""What another UAV announces: places in UTM, and when it will be there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from voxnav.array_types import Array

# More places than this are no prediction of a tracker, which has 40.
MAX_PLACES = 1000
# A stamp may be this much newer than the present time, because clocks are synchronised to no better.
AHEAD_S = 0.05
# Places on the earth in UTM [m] are within this, and those of a simulation.
MAX_M = 2.0e7


class AnnouncementError(ValueError):
    """Why an announcement cannot be used, as a sentence."""


@dataclass(frozen=True, eq=False)
class Announced:
    """A predicted trajectory. begin_s: time of the first place; places_utm: (k, 3); rounding_m: error of the places."""

    name: str
    priority: int
    begin_s: float
    heard_s: float
    places_utm: Array
    rounding_m: float

    @staticmethod
    def of(name: str, priority: int, begin_s: float, heard_s: float, places_utm: Array) -> Announced:
        """Raises AnnouncementError. places_utm: (k, 3), any float type."""
        if not len(places_utm):
            raise AnnouncementError("the trajectory of %s has no places" % name)
        if len(places_utm) > MAX_PLACES:
            raise AnnouncementError("the trajectory of %s has %d places, at most %d are read" % (
                name, len(places_utm), MAX_PLACES))
        places = np.asarray(places_utm, dtype=np.float64)
        if not (np.isfinite(places).all() and (np.abs(places) < MAX_M).all()):
            raise AnnouncementError("the trajectory of %s has places that are none on the earth" % name)
        return Announced(name, priority, begin_s, heard_s, places, rounding_m(places))

    @property
    def way_m(self) -> float:
        """The distance between the first place and the farthest one from it."""
        return float(np.linalg.norm(self.places_utm - self.places_utm[0], axis=1).max())


def rounding_m(places_utm: Array) -> float:
    """Returns by how much single precision, in which the message has its places, moves them: 0.25 m far north."""
    spacing = np.spacing(np.abs(places_utm).max(axis=0).astype(np.float32)).astype(np.float64)
    return float(np.linalg.norm(0.5 * spacing))


def begin_of(stamp_s: float, heard_s: float, max_delay_s: float) -> tuple[float, bool]:
    """Returns the time of the first place, and whether the stamp is of a clock that goes with ours.

    Clocks of UAVs need not be synchronised; MRS counts from the time of arrival, and so does this where the stamp
    cannot be right.
    """
    if -AHEAD_S <= heard_s - stamp_s <= max_delay_s:
        return stamp_s, True
    return heard_s, False
