# SPDX-License-Identifier: BSD-3-Clause
"""``flights.csv``: one row per flight, written as it ends, so that an interrupted campaign can go on."""

from __future__ import annotations

import csv
import fcntl
import io
import os

from voxnav.campaign.errors import CampaignError
from voxnav.campaign.rows import FlightRow, Key, csv_line, line_of, row_from


class FlightResults:
    """The open file. A row is appended by one write and reaches the disk before the next flight is waited for.

    Opening reads what is there. A line that was cut off while it was written is removed, and `repaired` tells of it.
    Only one campaign at a time may have the file open.
    """

    def __init__(self, path: str) -> None:
        self.path, self.repaired = path, ""
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            self._lock()
            self.rows = self._read()
        except BaseException:
            os.close(self._file)
            raise

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise CampaignError("another campaign is writing %s" % self.path) from error

    def _read(self) -> list[FlightRow]:
        with open(self.path, "rb") as source:
            data = source.read()
        whole = data[:data.rfind(b"\n") + 1]
        if len(whole) < len(data):
            self.repaired = "the last line of %s was cut off and is removed: %s" % (
                self.path, data[len(whole):].decode("utf-8", "replace"))
            os.ftruncate(self._file, len(whole))
        try:
            lines = list(csv.reader(io.StringIO(whole.decode("utf-8", "replace"))))
        except csv.Error as error:
            raise CampaignError("%s is no CSV file: %s" % (self.path, error)) from error
        if not lines:
            self._write(csv_line(list(FlightRow._fields)))
            return []
        if lines[0] != list(FlightRow._fields):
            raise CampaignError("%s has other columns than this version writes; choose another folder" % self.path)
        rows = []
        for number, cells in enumerate(lines[1:], 2):
            try:
                rows.append(row_from(cells))
            except ValueError as error:
                raise CampaignError("%s, line %d: %s; correct or remove it" % (self.path, number, error)) from error
        return rows

    def append(self, row: FlightRow) -> None:
        self._write(line_of(row))
        self.rows.append(row)

    def _write(self, line: str) -> None:
        data = line.encode("utf-8")
        if os.write(self._file, data) != len(data):
            raise OSError("%s: the disk is full" % self.path)
        os.fsync(self._file)

    def keys(self) -> set[Key]:
        return {row.key for row in self.rows}

    def close(self) -> None:
        os.close(self._file)

    def __enter__(self) -> FlightResults:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
