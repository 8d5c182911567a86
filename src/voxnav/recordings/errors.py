# SPDX-License-Identifier: BSD-3-Clause
"""Problems of recordings, and the error that readers of recordings raise."""

from __future__ import annotations

from typing import NamedTuple


class Problem(NamedTuple):
    """A problem and its remedy as sentences; to_do is empty if the sentence on the problem has it."""

    what: str
    to_do: str = ""


class DatasetError(ValueError):
    """The recording cannot be used; the text says what is missing and where. to_do: the remedy, for people."""

    def __init__(self, what: str, to_do: str = "") -> None:
        super().__init__("%s; %s" % (what, to_do) if to_do else what)
        self.problem = Problem(what, to_do)
