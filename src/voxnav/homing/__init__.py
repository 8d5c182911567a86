# SPDX-License-Identifier: BSD-3-Clause
"""The way home: where the flight began, a known way back to there, and whether the battery holds for a goal.

``HomeTrack`` keeps the way that was flown, without its loops and bent straight where the map knows free space.
``HomeKeeper`` decides when a flight begins and tells the length and the time of the way. ``reserve`` refuses goals from
which the vehicle would not come back.
"""

from voxnav.homing.keeper import HomeKeeper, HomeState
from voxnav.homing.reserve import Battery, beyond_reserve, reserve_warning
from voxnav.homing.track import HomeTrack

__all__ = ["Battery", "HomeKeeper", "HomeState", "HomeTrack", "beyond_reserve", "reserve_warning"]
