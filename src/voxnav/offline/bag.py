# SPDX-License-Identifier: BSD-3-Clause
"""Reads rosbags as a stream of records (see ``datasets``)."""

from __future__ import annotations

from typing import Iterator, Sequence

from voxnav.offline.bag_stream import BagStream
from voxnav.offline.datasets import Imu, Odometry, Scan
from voxnav.offline.sensors import MountedSensor
from voxnav.recordings.bag_files import BagFiles
from voxnav.recordings.errors import DatasetError
from voxnav.recordings.left_out import LeftOut
from voxnav.recordings.plan import BagOptions, RecordingPlan


class Bag:
    """The clouds of the bags of one recording, with its odometry and IMU samples if there are any.

    Records come with rising stamps, a cloud after the odometry and the IMU samples of its sweep; IMU samples are in
    the axes of the body. Messages that are left out are counted in ``left_out``. Raises DatasetError.
    """

    def __init__(self, paths: Sequence[str], options: BagOptions = BagOptions()) -> None:
        self.left_out = LeftOut()
        self._files = BagFiles(paths)
        self.plan = RecordingPlan(self._files, options)
        if self.plan.error is not None or self.plan.cloud is None or self.plan.mount is None:
            self._files.close()
            raise DatasetError(self.plan.error or "the recording has no clouds")
        self.T_B_L, self.origin_m = self.plan.mount.T_B_L, self.plan.origin_m
        self.has_poses = self.plan.odometry is not None
        self.has_imu = self.plan.imu is not None
        self.topic = self.plan.cloud.name
        self.further = [MountedSensor(sensor.what, sensor.T_B_L, sensor.topic.name) for sensor in self.plan.further]
        self.num_scans = self.plan.cloud.topic.num + sum(sensor.topic.topic.num for sensor in self.plan.further)
        self.warnings = [warning.what for warning in self.plan.warnings]

    def close(self) -> None:
        self._files.close()

    def __iter__(self) -> Iterator[Imu | Odometry | Scan]:
        self.left_out = LeftOut()
        stream = BagStream(self.plan, self._files, self.left_out)
        yield from stream.records()
        self.warnings += stream.notes()
