# SPDX-License-Identifier: BSD-3-Clause
"""Whether what was mapped covers what was recorded."""

from __future__ import annotations

# A recording counts as covered when so many of its scans are in the map and no longer stretch is missing.
MIN_SHARE = 0.9
# A scan at the beginning and one at the end may lie outside of the poses, however short the recording is.
NUM_EDGE_SCANS = 2
MAX_HOLE_S = 1.0


class Coverage:
    """Told of each scan, in any order, whether it was mapped. Stamps in seconds."""

    def __init__(self) -> None:
        self._scans: list[tuple[float, bool]] = []
        self._num_lost = 0

    def add(self, stamp_s: float, is_used: bool) -> None:
        self._scans.append((stamp_s, is_used))

    def add_lost(self, count: int) -> None:
        """Scans that could not even be read, at times that nobody knows."""
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
        """The longest time from one mapped scan, or the first of all, to the next, or the last of all, with scans in
        between that were not mapped."""
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
