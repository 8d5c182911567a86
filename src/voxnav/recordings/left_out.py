# SPDX-License-Identifier: BSD-3-Clause
"""Counts what was left out of a recording and why, with the first and the last time at which it happened."""

from __future__ import annotations

from typing import Any, Dict, NamedTuple, Tuple

REPEATED = "its stamp repeats that of the one before"

# There are few different reasons; this bounds the memory if a reason should contain a number.
MAX_REASONS = 200


class Left(NamedTuple):
    """How often a kind of message was left out for one reason, and the first and last time in ns, None if not known."""

    num: int
    first_ns: int | None
    last_ns: int | None


class LeftOut:
    """Counts by the kind of message ("cloud", "odometry", ...) and the reason. Their number is bounded."""

    def __init__(self) -> None:
        self._counts: Dict[Tuple[str, str], Left] = {}

    def add(self, what: str, reason: str, stamp_ns: int | None = None, count: int = 1) -> None:
        key = (what, reason)
        if key not in self._counts and len(self._counts) >= MAX_REASONS:
            key = (what, "other reasons")
        known = self._counts.get(key, Left(0, stamp_ns, None))
        self._counts[key] = Left(known.num + count, known.first_ns, stamp_ns)

    def __bool__(self) -> bool:
        return bool(self._counts)

    def count(self, what: str, but: str = "") -> int:
        """Returns how many messages of a kind were left out, except those with the reason `but`."""
        return sum(left.num for (name, reason), left in self._counts.items() if name == what and reason != but)

    def take(self, other: LeftOut) -> None:
        """Adds all counts of another object."""
        for (what, reason), left in other._counts.items():
            self.add(what, reason, left.first_ns, left.num)
            key = (what, reason)
            if key in self._counts:
                self._counts[key] = self._counts[key]._replace(last_ns=left.last_ns)

    def rows(self) -> list[dict[str, Any]]:
        """Returns a dict per kind and reason (what, reason, count, first_s, last_s), the most frequent first."""
        ordered = sorted(self._counts.items(), key=lambda item: (-item[1].num, item[0]))
        return [{"what": what, "reason": reason, "count": left.num, "first_s": _seconds(left.first_ns),
                 "last_s": _seconds(left.last_ns)} for (what, reason), left in ordered]

    def lines(self) -> list[str]:
        """Returns the rows as lines of text for people."""
        out = []
        for row in self.rows():
            when = ""
            if row["first_s"] is not None:
                when = " (at %.3f)" % row["first_s"] if row["count"] == 1 else " (from %.3f to %.3f)" % (
                    row["first_s"], row["last_s"])
            out.append("%d x %s left out%s: %s" % (row["count"], row["what"], when, row["reason"]))
        return out


def _seconds(stamp_ns: int | None) -> float | None:
    return None if stamp_ns is None else 1e-9 * stamp_ns
