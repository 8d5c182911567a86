# SPDX-License-Identifier: BSD-3-Clause
"""The error that readers of recordings raise."""

from __future__ import annotations


class DatasetError(ValueError):
    """The recording cannot be used; the text says what is missing and where."""
