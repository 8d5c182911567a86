# SPDX-License-Identifier: BSD-3-Clause
"""What a campaign tells people while it flies."""

from __future__ import annotations

import time

from voxnav.campaign.rows import FlightRow


def say(line: str) -> None:
    """Prints a line at once, also into a file or a pipe."""
    print(line, flush=True)


class CampaignProgress:
    """Says a line for each flight that has ended, with an estimate of the time that is left."""

    def __init__(self, total: int) -> None:
        self._total, self._done, self._started = total, 0, time.monotonic()

    def add(self, row: FlightRow) -> None:
        self._done += 1
        left_s = (time.monotonic() - self._started) / self._done * (self._total - self._done)
        took = "" if row.wall_s is None else " in %.0f s" % row.wall_s
        say("[%d/%d] %s: %s%s; %.0f min left" % (self._done, self._total, row, row.outcome, took, left_s / 60.0))
