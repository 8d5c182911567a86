# SPDX-License-Identifier: BSD-3-Clause
"""Fills gaps in recorded odometry by LiDAR odometry.

Poses are not interpolated over more than ``mapper/max_pose_gap_s``. In a longer gap LiDAR odometry begins with the last
sweeps before the gap, and its frame is fixed by the recorded pose of the last of them.
"""

from __future__ import annotations

from collections import deque
from typing import Any, Deque, NamedTuple

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.offline.datasets import Imu

# From before a gap these are kept: enough sweeps to begin a map, and the IMU samples and poses of this time.
_NUM_SWEEPS = 5
_KEPT_NS = 2_000_000_000


class TrackedPose(NamedTuple):
    """A stamped pose T (4, 4) in frame O or in the frame of a LiDAR odometry."""

    stamp_ns: int
    T: Array


class _Gap:
    """One run of LiDAR odometry. Its poses are in O once a sweep before the gap relates it to the recorded poses."""

    def __init__(self, config: Any, T_B_L: Array, last: TrackedPose) -> None:
        self.odometry = voxnav.LidarOdometry(config, T_B_L)
        self.last = last  # the last recorded pose before the gap
        self.num_sweeps = 0  # the number of sweeps for which it found poses
        self._T_O_V: Array | None = None  # V is the origin of this LiDAR odometry
        self._given_ns = last.stamp_ns

    def add_imu(self, imu: Imu) -> None:
        self.odometry.add_imu(np.array([imu.stamp_ns]), imu.gyro.reshape(1, 3), imu.accel.reshape(1, 3))

    def add_sweep(self, sweep: Any, T_O_B: Array | None) -> TrackedPose | None:
        """Adds a sweep. Returns the pose that was found at its start, unless a pose was recorded there.

        T_O_B: the recorded pose at the start of the sweep, or None.
        """
        result = self.odometry.add_cloud(1e-9 * sweep.start_ns, sweep.points, 1e-9 * sweep.time_offsets_ns)
        if not result.is_new or result.quality.state == voxnav.OdometryState.COASTING:
            return None  # a pose that is only predicted is not used
        if T_O_B is not None:
            self._T_O_V = T_O_B @ np.linalg.inv(result.pose)
            return None
        if self._T_O_V is None or sweep.start_ns <= self._given_ns:
            return None
        self._given_ns = sweep.start_ns
        self.num_sweeps += 1
        return TrackedPose(sweep.start_ns, self._T_O_V @ result.pose)


class PoseGaps:
    """Takes all poses, IMU samples and sweeps of a recording, and finds poses in gaps of the odometry.

    notes: a sentence for each gap. config: LidarOdometryConfig; with None gaps are noted but not filled.
    """

    def __init__(self, config: Any, T_B_L: Array, max_gap_s: float) -> None:
        self.notes: list[str] = []
        self.lost_s = 0.0
        self._config, self._T_B_L, self._max_gap_ns = config, T_B_L, int(1e9 * max_gap_s)
        self._poses: Deque[TrackedPose] = deque()
        self._imu: Deque[Imu] = deque()
        self._sweeps: Deque[Any] = deque(maxlen=_NUM_SWEEPS)
        self._gap: _Gap | None = None

    def add_pose(self, stamp_ns: int, T_O_B: Array) -> list[TrackedPose]:
        """Adds a recorded pose. Returns the poses before it that LiDAR odometry found."""
        found: list[TrackedPose] = []
        last = self._poses[-1] if self._poses else None
        if last is not None and stamp_ns <= last.stamp_ns:
            return found
        if last is not None and stamp_ns - last.stamp_ns > self._max_gap_ns:
            if self._gap is None:
                found = self._begin(last)
            self._note(last, stamp_ns)
        self._gap = None
        self._poses.append(TrackedPose(stamp_ns, T_O_B))
        _forget(self._poses, stamp_ns - _KEPT_NS)
        return [pose for pose in found if pose.stamp_ns < stamp_ns]

    def add_imu(self, imu: Imu) -> None:
        self._imu.append(imu)
        _forget(self._imu, imu.stamp_ns - _KEPT_NS)
        if self._gap is not None:
            self._gap.add_imu(imu)

    def add_sweep(self, sweep: Any) -> list[TrackedPose]:
        """Adds a sweep, after all poses of its time. Returns the poses of LiDAR odometry if the sweep lies in a gap."""
        self._sweeps.append(sweep)
        if not self._poses:
            return []
        if self._gap is not None:
            pose = self._gap.add_sweep(sweep, None)
            return [] if pose is None else [pose]
        last = self._poses[-1]
        if sweep.start_ns + sweep.duration_ns - last.stamp_ns <= self._max_gap_ns:
            return []
        return self._begin(last)

    def end(self) -> None:
        """Ends the recording, and notes odometry that ended before."""
        if self._gap is not None and self._sweeps:
            self._note(self._gap.last, self._sweeps[-1].start_ns, is_end=True)

    def _begin(self, last: TrackedPose) -> list[TrackedPose]:
        if self._config is None:
            return []
        self._gap = _Gap(self._config, self._T_B_L, last)
        for imu in self._imu:
            self._gap.add_imu(imu)
        found = [self._gap.add_sweep(sweep, self._recorded(sweep.start_ns)) for sweep in self._sweeps]
        return [pose for pose in found if pose is not None]

    def _recorded(self, stamp_ns: int) -> Array | None:
        """Returns the recorded pose (4, 4) at a stamp, or None outside of the poses that are kept and within gaps."""
        for before, after in zip(self._poses, list(self._poses)[1:]):
            if before.stamp_ns <= stamp_ns <= after.stamp_ns and after.stamp_ns - before.stamp_ns <= self._max_gap_ns:
                ratio = (stamp_ns - before.stamp_ns) / (after.stamp_ns - before.stamp_ns)
                T: Array = voxnav.interpolate_pose(before.T, after.T, ratio)
                return T
        return None

    def _note(self, last: TrackedPose, until_ns: int, is_end: bool = False) -> None:
        length_s = 1e-9 * (until_ns - last.stamp_ns)
        num_sweeps = 0 if self._gap is None else self._gap.num_sweeps
        text = "odometry is silent for %.2f s from %.3f %s" % (
            length_s, 1e-9 * last.stamp_ns, "to the end" if is_end else "on")
        if num_sweeps:
            text += ": covered by LiDAR odometry (%d scans)" % num_sweeps
        else:
            text += ", longer than max_pose_gap_s (%.2f s): scans of that time have no pose" % (1e-9 * self._max_gap_ns)
        if len(self.notes) < 100:
            self.notes.append(text)


def _forget(kept: Any, before_ns: int) -> None:
    while kept and kept[0].stamp_ns < before_ns:
        kept.popleft()
