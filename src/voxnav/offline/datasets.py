# SPDX-License-Identifier: BSD-3-Clause
"""Recordings as one stream: folders of raw scans, and rosbags.

A dataset iterates over ``Imu``, ``Odometry`` and ``Scan`` records in order of their stamps, and knows
``num_scans`` for the progress bar. ``warnings`` lists what was wrong with the recording but could be passed over.
"""

import bisect
import collections
import os

import numpy as np

from voxnav import files

# points: (n, 4) float32 x y z intensity, frame L, or (h, w, 4) when the scan is organised;
# raw: message with its field layout instead of points; pose: T_O_L at the stamp, or None;
# pose_at: function from a time after the stamp [s] to T_O_L or None, for sensors that move while they turn, or None.
Scan = collections.namedtuple("Scan", "stamp points raw pose pose_at")
Imu = collections.namedtuple("Imu", "stamp gyro accel")


MAX_WARNINGS = 1000


class DatasetError(ValueError):
    """The recording cannot be used; the text says what is missing and where."""


def interpolate_pose(stamps, poses, stamp):
    """Pose at a stamp between two others; None outside. Rotation by the shorter arc (normalised linear blend)."""
    k = bisect.bisect_left(stamps, stamp)
    if k < len(stamps) and stamps[k] == stamp:
        return poses[k]
    if k == 0 or k == len(stamps):
        return None
    ratio = (stamp - stamps[k - 1]) / (stamps[k] - stamps[k - 1])
    a, b = poses[k - 1], poses[k]
    qa, qb = files.quaternion_from_rotation(a[:3, :3]), files.quaternion_from_rotation(b[:3, :3])
    if np.dot(qa, qb) < 0:
        qb = -qb
    T = np.eye(4)
    T[:3, :3] = files.rotation_from_quaternion((1 - ratio) * qa + ratio * qb)
    T[:3, 3] = (1 - ratio) * a[:3, 3] + ratio * b[:3, 3]
    return T


class ScanFolder:
    """``scans/%06d.bin`` (float32 x y z intensity rows), ``times.txt`` and TUM poses.

    Raises DatasetError naming the file when something is missing, truncated or of another length.
    """

    def __init__(self, directory, poses=None):
        self.warnings = []
        self._scan_dir = os.path.join(directory, "scans")
        if not os.path.isdir(self._scan_dir):
            raise DatasetError("%s: no folder scans/ in it" % directory)
        self._names = sorted(name for name in os.listdir(self._scan_dir) if name.endswith(".bin"))
        if not self._names:
            raise DatasetError("%s: holds no .bin files" % self._scan_dir)
        self._stamps = self._read_times(os.path.join(directory, "times.txt"))
        self._poses = self._poses_at(poses) if poses else [None] * len(self._names)
        self.num_scans = len(self._names)

    def _read_times(self, path):
        if not os.path.exists(path):
            self.warnings.append("no times.txt: scans are taken to be 0.1 s apart")
            return np.arange(len(self._names)) * 0.1
        try:
            stamps = np.loadtxt(path, ndmin=1)
        except ValueError as error:
            raise DatasetError("%s: %s" % (path, error))
        if len(stamps) < len(self._names):
            raise DatasetError("%s: %d times for %d scans" % (path, len(stamps), len(self._names)))
        return stamps[:len(self._names)]

    def _poses_at(self, path):
        stamps, poses = files.read_tum(path)
        out = []
        for stamp in self._stamps:
            nearest = int(np.argmin(np.abs(stamps - stamp)))
            if abs(stamps[nearest] - stamp) > 0.05:
                raise DatasetError("%s: no pose within 0.05 s of scan time %.6f" % (path, stamp))
            out.append(poses[nearest])
        return out

    def __iter__(self):
        for name, stamp, pose in zip(self._names, self._stamps, self._poses):
            path = os.path.join(self._scan_dir, name)
            rows, surplus = divmod(os.path.getsize(path), 16)
            if surplus and len(self.warnings) < MAX_WARNINGS:
                self.warnings.append("%s: not whole rows of four floats, truncated; the last row is left out" % path)
            data = np.fromfile(path, dtype="<f4", count=4 * rows)
            yield Scan(float(stamp), data.reshape(-1, 4), None, pose, None)
