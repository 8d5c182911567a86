# SPDX-License-Identifier: BSD-3-Clause
"""Matplotlib, which only people on the ground need: an aircraft maps and flies without it."""

from typing import Any


class PicturesUnavailable(RuntimeError):
    """A picture was asked for where Matplotlib is not installed."""


def pyplot() -> Any:
    """Returns the module matplotlib.pyplot, set to draw into files. Raises PicturesUnavailable."""
    try:
        import matplotlib
    except ImportError as error:
        raise PicturesUnavailable("pictures need Matplotlib (package python3-matplotlib): %s" % error) from error
    matplotlib.use("Agg")
    import matplotlib.pyplot

    return matplotlib.pyplot


def require_pictures() -> None:
    """Ends the program with a message if pictures cannot be drawn, before a long computation and not after it."""
    try:
        pyplot()
    except PicturesUnavailable as error:
        raise SystemExit(str(error)) from error
