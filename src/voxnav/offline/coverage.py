# SPDX-License-Identifier: BSD-3-Clause
"""Judges whether the mapped scans cover the recording."""

from __future__ import annotations

# A recording is covered if at least this share of its scans is in the map and no hole is longer than MAX_HOLE_S.
MIN_SHARE = 0.9
# In a recording of any length, a scan at the beginning and one at the end may lie outside of the poses.
NUM_EDGE_SCANS = 2
MAX_HOLE_S = 1.0


class Coverage:
    """Collects for each scan, in any order, whether it was mapped. Stamps are in seconds."""

    def __init__(self) -> None:
        self._scans: list[tuple[float, bool]] = []
        self._num_lost = 0

    def add(self, stamp_s: float, is_used: bool) -> None:
        self._scans.append((stamp_s, is_used))

    def add_lost(self, count: int) -> None:
        """Adds scans that could not be read, whose times are not known."""
        self._num_lost += count

    @property
    def num_scans(self) -> int:
        return len(self._scans) + self._num_lost

    @property
    def num_used(self) -> int:
        return sum(is_used for _, is_used in self._scans)

    @property
    def share(self) -> float:
        return self.num_used / self.num_scans if self.num_scans else 0.0

    @property
    def longest_hole_s(self) -> float:
        """Returns the longest time between two mapped scans with scans between them that were not mapped.

        The first and the last scan of all count as mapped here.
        """
        longest, start, has_lost = 0.0, None, False
        for stamp_s, is_used in sorted(self._scans):
            start = stamp_s if start is None else start
            has_lost |= not is_used
            if has_lost:
                longest = max(longest, stamp_s - start)
            if is_used:
                start, has_lost = stamp_s, False
        return longest

    @property
    def is_enough(self) -> bool:
        num_missing = self.num_scans - self.num_used
        is_few = self.share >= MIN_SHARE or (num_missing <= NUM_EDGE_SCANS and self.num_used > num_missing)
        return is_few and self.longest_hole_s <= MAX_HOLE_S

    def sentence(self) -> str:
        text = "%d of %d scans were mapped (%.1f %%)" % (self.num_used, self.num_scans, 100.0 * self.share)
        if self.longest_hole_s > 0.0:
            text += ", with at most %.2f s without any" % self.longest_hole_s
        if not self.is_enough:
            text += ": this does not cover the recording (%.0f %% or all but %d, and no more than %.1f s without" % (
                100.0 * MIN_SHARE, NUM_EDGE_SCANS, MAX_HOLE_S) + " any, would)"
        return text
