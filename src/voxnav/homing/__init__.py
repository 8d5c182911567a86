# SPDX-License-Identifier: BSD-3-Clause
"""The way home: where the flight began, a known way back to there, and whether the battery holds for a goal.

``HomeTrack`` keeps the way that was flown, without its loops and bent straight where the map knows free space.
``HomeKeeper`` decides when a flight begins and tells the length and the time of the way. ``known_way`` lets it stand in
for a search that finds none. ``MapCorrections`` tells how places move when the graph corrects the map. ``reserve``
refuses goals from which the vehicle would not come back, and tells when it is time to return.
"""

from voxnav.homing.corrections import MapCorrection, MapCorrections
from voxnav.homing.keeper import HomeKeeper, HomeState
from voxnav.homing.known_way import or_way_home, way_in_O
from voxnav.homing.reserve import Battery, ReserveWatch, Watch, beyond_reserve, watch_reserve
from voxnav.homing.track import HomeTrack

__all__ = ["Battery", "HomeKeeper", "HomeState", "HomeTrack", "MapCorrection", "MapCorrections", "ReserveWatch",
           "Watch", "beyond_reserve", "or_way_home", "watch_reserve", "way_in_O"]
