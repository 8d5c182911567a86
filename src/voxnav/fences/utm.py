# SPDX-License-Identifier: BSD-3-Clause
"""Universal transverse Mercator coordinates on the ellipsoid of WGS84.

Source: Karney, Transverse Mercator with an accuracy of a few nanometers, Journal of Geodesy 2011, equations 7 to 12 and
35 (Krueger's series, here to the fourth order, which is exact to a micrometre within a zone).
"""

from __future__ import annotations

import math

# Equatorial radius [m] and flattening of WGS84; scale of UTM on the central meridian, and its false origin [m].
RADIUS_M, FLATTENING = 6378137.0, 1.0 / 298.257223563
SCALE, EAST_M, SOUTH_M = 0.9996, 500000.0, 10000000.0
ZONE_DEG = 6.0

_N = FLATTENING / (2.0 - FLATTENING)
_ECCENTRICITY = math.sqrt(FLATTENING * (2.0 - FLATTENING))
_RECTIFYING_M = RADIUS_M / (1.0 + _N) * (1.0 + _N ** 2 / 4.0 + _N ** 4 / 64.0)
_ALPHA = (
    _N / 2.0 - 2.0 * _N ** 2 / 3.0 + 5.0 * _N ** 3 / 16.0 + 41.0 * _N ** 4 / 180.0,
    13.0 * _N ** 2 / 48.0 - 3.0 * _N ** 3 / 5.0 + 557.0 * _N ** 4 / 1440.0,
    61.0 * _N ** 3 / 240.0 - 103.0 * _N ** 4 / 140.0,
    49561.0 * _N ** 4 / 161280.0,
)


def zone_of(longitude_deg: float) -> int:
    """Returns the number of the zone, 1 to 60, as MRS chooses it: without the exceptions of Norway and Svalbard."""
    return int((longitude_deg + 180.0) // ZONE_DEG) % 60 + 1


def utm_of(latitude_deg: float, longitude_deg: float, zone: int, is_south: bool) -> tuple[float, float]:
    """Returns east and north [m] in a zone, which need not be that of the place. is_south: origin of the southern half.

    Raises ValueError for a latitude or longitude that is none, or beyond 84 degrees, where UTM ends.
    """
    if not (abs(latitude_deg) <= 84.0 and abs(longitude_deg) <= 180.0):
        raise ValueError("latitude %g, longitude %g deg is no place of UTM" % (latitude_deg, longitude_deg))
    latitude = math.radians(latitude_deg)
    from_meridian_deg = math.fmod(longitude_deg - (ZONE_DEG * zone - 183.0) + 540.0, 360.0) - 180.0
    longitude = math.radians(from_meridian_deg)
    sine = math.sin(latitude)
    tangent = math.sinh(math.atanh(sine) - _ECCENTRICITY * math.atanh(_ECCENTRICITY * sine))
    xi, eta = math.atan2(tangent, math.cos(longitude)), math.asinh(
        math.sin(longitude) / math.hypot(tangent, math.cos(longitude)))
    north = xi + sum(a * math.sin(2 * j * xi) * math.cosh(2 * j * eta) for j, a in enumerate(_ALPHA, 1))
    east = eta + sum(a * math.cos(2 * j * xi) * math.sinh(2 * j * eta) for j, a in enumerate(_ALPHA, 1))
    return (EAST_M + SCALE * _RECTIFYING_M * east,
            (SOUTH_M if is_south else 0.0) + SCALE * _RECTIFYING_M * north)
