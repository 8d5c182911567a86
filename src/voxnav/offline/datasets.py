# SPDX-License-Identifier: BSD-3-Clause
"""Recordings, which are folders of raw scans or rosbags, as streams of records.

A dataset iterates over ``Imu``, ``Odometry`` and ``Scan`` records, each scan after the other records of its sweep. It
has ``num_scans`` for the progress bar, and the flags ``has_poses`` and ``has_imu``. ``warnings`` lists faults that do
not prevent mapping, ``left_out`` counts messages that were not used, and ``origin_m`` was subtracted from its positions
(None: nothing was). ``topic`` and ``further`` say which sensors its scans are of.
"""

from __future__ import annotations

import os
from typing import Any, Iterator, NamedTuple

import numpy as np

from voxnav import files
from voxnav.array_types import Array
from voxnav.recordings import origin
from voxnav.recordings.errors import DatasetError
from voxnav.recordings.left_out import LeftOut


class Scan(NamedTuple):
    """One cloud.

    stamp_ns: the start of the sweep; points: (n, 4) float32 x y z intensity in frame L, or (h, w, 4) if organised;
    raw: a message with its field layout instead of points; T_O_L: (4, 4), one pose for the scan;
    sensor: the number of the sensor, as Sweep.sensor.
    """

    stamp_ns: int
    points: Array | None
    raw: Any
    T_O_L: Array | None
    sensor: int = 0


class Imu(NamedTuple):
    """One IMU sample: rotation rate [rad/s] and specific force [m/s^2], both (3,)."""

    stamp_ns: int
    gyro: Array
    accel: Array


class Odometry(NamedTuple):
    """A recorded pose of the body: position in metres and quaternion x y z w."""

    stamp_ns: int
    position: tuple[float, float, float]
    q_xyzw: tuple[float, float, float, float]


MAX_WARNINGS = 1000


class ScanFolder:
    """A folder with ``scans/%06d.bin`` (float32 rows x y z intensity), ``times.txt`` and poses in TUM format.

    Raises DatasetError naming a file that is missing, truncated or of another length.
    """

    def __init__(self, directory: str, poses: str | None = None) -> None:
        self.warnings: list[str] = []
        self.left_out = LeftOut()
        self.origin_m: Array | None = None
        self._scan_dir = os.path.join(directory, "scans")
        if not os.path.isdir(self._scan_dir):
            raise DatasetError("%s: no folder scans/ in it" % directory)
        self._names = sorted(name for name in os.listdir(self._scan_dir) if name.endswith(".bin"))
        if not self._names:
            raise DatasetError("%s: holds no .bin files" % self._scan_dir)
        self._stamps = self._read_times(os.path.join(directory, "times.txt"))
        self._poses = self._poses_at(poses) if poses else [None] * len(self._names)
        self.num_scans = len(self._names)
        self.has_poses = poses is not None
        self.topic = ""
        self.further: list[Any] = []  # it has one sensor
        self.has_imu = False

    def _read_times(self, path: str) -> Array:
        if not os.path.exists(path):
            self.warnings.append("no times.txt: scans are taken to be 0.1 s apart")
            return np.arange(len(self._names)) * 0.1
        stamps = files.read_numbers(path)
        if len(stamps) < len(self._names):
            raise DatasetError("%s: %d times for %d scans" % (path, len(stamps), len(self._names)))
        return stamps[:len(self._names)]

    def _poses_at(self, path: str) -> list[Array | None]:
        stamps, poses = files.read_tum(path)
        self.origin_m = origin.origin_of(poses[:, :3, 3])
        if self.origin_m is not None:
            poses[:, :3, 3] -= self.origin_m
        out = []
        for stamp in self._stamps:
            nearest = int(np.argmin(np.abs(stamps - stamp)))
            if abs(stamps[nearest] - stamp) > 0.05:
                raise DatasetError("%s: no pose within 0.05 s of scan time %.6f" % (path, stamp))
            out.append(poses[nearest])
        return out

    def __iter__(self) -> Iterator[Scan]:
        for name, stamp, pose in zip(self._names, self._stamps, self._poses):
            path = os.path.join(self._scan_dir, name)
            rows, surplus = divmod(os.path.getsize(path), 16)
            if surplus and len(self.warnings) < MAX_WARNINGS:
                self.warnings.append("%s: not whole rows of four floats, truncated; the last row is left out" % path)
            data = np.fromfile(path, dtype="<f4", count=4 * rows)
            yield Scan(int(round(1e9 * stamp)), data.reshape(-1, 4), None, pose)
