# SPDX-License-Identifier: BSD-3-Clause
"""The transform from UTM, for as long as it may be believed."""

from __future__ import annotations

from typing import Optional

from voxnav.array_types import Array

# tf, and the message that tells of a jump, are stamped by different clocks of one vehicle, at most this far apart.
SAME_TIME_S = 1e-3


class OriginUnknown(LookupError):
    """Why it is not known where UTM is, as a sentence."""


class KeptTransform:
    """The last T_O_utm, (4, 4), that tf told.

    The origins of estimators stand still against each other but for drift, so that a transform holds on while tf is
    late or lost. It does not for ever: nobody tells any more that it is still so. And it does not when the estimator
    was re-initialised, since O is elsewhere then, whatever its name.
    """

    def __init__(self, max_age_s: float) -> None:
        self._max_age_s = max_age_s
        self._T: Optional[Array] = None
        self._stamp_s: Optional[float] = None  # when tf told it; None: it is static
        self._jump_s: Optional[float] = None  # when O jumped last

    def forget(self, jump_s: Optional[float] = None) -> None:
        """Forgets the transform. jump_s: when O jumped; what tf told of earlier times counts no more then."""
        self._T = self._stamp_s = None
        self._jump_s = jump_s

    def take(self, T_O_utm: Array, stamp_s: Optional[float]) -> None:
        """Takes what tf tells. stamp_s: for which time; None for a static transform."""
        if stamp_s is not None and self._jump_s is not None and stamp_s < self._jump_s - SAME_TIME_S:
            return
        self._T, self._stamp_s = T_O_utm, stamp_s

    def at(self, now_s: float) -> Array:
        """Returns the transform for the present time. Raises OriginUnknown."""
        if self._T is None:
            since = "yet" if self._jump_s is None else "since the odometry jumped"
            raise OriginUnknown("no transform " + since)
        if self._stamp_s is not None and abs(now_s - self._stamp_s) > self._max_age_s:
            # The sentence does not tell the age, which would give a new text each time.
            raise OriginUnknown("nobody has told its transform for more than %.1f s" % self._max_age_s)
        return self._T
