# SPDX-License-Identifier: BSD-3-Clause
"""rviz beside a demonstration, and its picture."""

from __future__ import annotations

import argparse
import os
import shutil
import time

from voxnav.array_types import Array
from voxnav.demo import pictures, processes
from voxnav.demo.processes import Environment, Process
from voxnav.demo.record import FlightRecord
from voxnav.plotting import PicturesUnavailable


class Rviz:
    """rviz on the present screen, or on a virtual one if there is none; it runs until stop()."""

    # Software rendering needs a while until maps and markers are on screen.
    _DRAWING_S = 25.0

    def __init__(self, env: Environment, config: str, log: str) -> None:
        self.problem = ""
        self._screen: Process | None = None
        self._rviz: Process | None = None
        if shutil.which("rviz") is None:
            self.problem = "rviz is not installed: no picture of it"
            return
        self._display = os.environ.get("DISPLAY")
        if not self._display:
            self._screen, self._display = processes.virtual_screen()
        if not self._display:
            self.problem = "no display and no Xvfb: no rviz picture"
            return
        self._log, self._started = log, time.monotonic()
        rviz_env = dict(env, DISPLAY=self._display, LIBGL_ALWAYS_SOFTWARE="1")
        self._rviz = processes.Process(["rviz", "-d", config], log, rviz_env)

    def picture(self, path: str) -> str:
        """Screenshot. Returns what could not be done, or ''."""
        if self.problem:
            return self.problem
        time.sleep(max(5.0, self._started + self._DRAWING_S - time.monotonic()))
        is_running = self._rviz is not None and self._rviz.is_running()
        is_taken = is_running and self._display is not None and processes.screenshot(self._display, path)
        return "" if is_taken else "the rviz picture could not be taken, see %s" % self._log

    def stop(self) -> None:
        for process in (self._rviz, self._screen):
            if process:
                process.stop()


def show(args: argparse.Namespace, env: Environment, record: FlightRecord, rviz: Rviz | None, rviz_config: str,
         trunks: Array | None = None) -> list[str]:
    """Pictures of what was recorded, into args.out. Returns what could not be done.

    rviz: the running one, or None to start one now with rviz_config.
    """
    notes = []
    try:
        pictures.top_view(os.path.join(args.out, "top_view.png"), record, trunks)
    except PicturesUnavailable as error:
        notes.append(str(error))
    if args.no_rviz:
        return notes
    note = _picture(rviz or Rviz(env, rviz_config, os.path.join(args.out, "rviz.log")), args.out)
    if note:  # rviz itself sometimes dies as it starts
        note = _picture(Rviz(env, rviz_config, os.path.join(args.out, "rviz_again.log")), args.out)
    return notes + [note] if note else notes


def _picture(rviz: Rviz, out: str) -> str:
    """Takes it and stops rviz. Returns what could not be done, or ''."""
    try:
        return rviz.picture(os.path.join(out, "rviz.png"))
    finally:
        rviz.stop()
