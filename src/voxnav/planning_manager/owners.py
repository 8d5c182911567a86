# SPDX-License-Identifier: BSD-3-Clause
"""Tells who flies the vehicle, as far as the control manager says it."""

from typing import Optional

from voxnav.planning_manager.inputs import Control, TrackerState
from voxnav.planning_manager.reasons import Because, Reason


def who_flies(control: Control) -> Optional[Because]:
    """Tells who or what flies the vehicle instead of those who set goals; None while it may be flown to goals.

    The control manager reports all of these as not flying normally, so the more particular ones are asked first.
    """
    if control.is_repelling:
        return Because(Reason.REPELLED, "the bumper of the control manager repels the vehicle")
    if control.is_remote:
        return Because(Reason.REMOTE_CONTROL, "a pilot flies the vehicle by remote control")
    if control.is_flying:
        return None
    names = " with ".join(name for name in (control.tracker, control.controller) if name)
    by_whom = " (%s)" % names if names else ""  # an emergency has a controller of its own
    if control.state is TrackerState.LAND:
        return Because(Reason.LANDING, "the vehicle lands" + by_whom)
    if control.is_on_ground:
        return Because(Reason.NOT_FLYING, "not flying")
    # The control manager does not tell these apart: a flight mode that the pilot chose on the transmitter, for one.
    what = "not flown normally: callbacks are disabled, a pilot has the vehicle, or it is an emergency"
    return Because(Reason.NOT_NORMAL, what + by_whom)
