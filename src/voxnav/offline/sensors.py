# SPDX-License-Identifier: BSD-3-Clause
"""What the runner keeps of each sensor of a recording."""

from __future__ import annotations

from typing import Any, Callable, ContextManager, NamedTuple

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.offline.coverage import Coverage
from voxnav.offline.datasets import Scan
from voxnav.offline.sensor_configs import SensorConfigs
from voxnav.recordings.cloud_samples import layout_of


class MountedSensor(NamedTuple):
    """what: how its clouds are called where they are left out; T_B_L: (4, 4) pose of the sensor on the body;
    topic: that of its messages, empty if its scans are files."""

    what: str
    T_B_L: Array
    topic: str = ""


class SensorInput:
    """The filters of one sensor, and how much of what it recorded was mapped. number: see Sweep.sensor."""

    def __init__(self, number: int, sensor: MountedSensor, configs: SensorConfigs) -> None:
        self.number, self.what = number, sensor.what
        self.T_B_L = voxnav.as_sent(np.ascontiguousarray(sensor.T_B_L))
        self.T_L_B = np.linalg.inv(self.T_B_L)
        self.coverage = Coverage()
        self.limits = configs.limits
        self.filter = voxnav.CloudFilter(configs.filter)
        self._pcl_filters = voxnav.make_pcl_filters(configs.pcl)
        self._open_beams = voxnav.OpenBeams(configs.open_beams) if configs.open_beams.is_enabled else None

    def sweep(self, scan: Scan, time: Callable[[str], ContextManager[None]]) -> tuple[voxnav.FilterResult, Any]:
        """Filters a scan. Returns the FilterResult and the Sweep. time: see Stages. Raises ValueError saying what is
        wrong with the scan."""
        filtered, open_beams = self._filter(scan)
        for pcl_filter in self._pcl_filters:
            with time("pcl " + pcl_filter.name):
                pcl_filter.apply(filtered)
        return filtered, filtered.sweep(scan.stamp_ns, open_beams, self.number)

    def _filter(self, scan: Scan) -> tuple[voxnav.FilterResult, Array | None]:
        """Returns the FilterResult, and the open beams (k, 3) or None."""
        if scan.raw is None:
            return self.filter.apply(np.ascontiguousarray(scan.points, dtype=np.float32)), None
        layout = layout_of(scan.raw)
        # By the stamp that the cloud bears: absolute times of its points are of the same clock.
        filtered = self.filter.apply_raw(scan.raw.data, layout, stamp_ns=scan.raw.header.stamp.to_nsec())
        return filtered, self._open_beams.find(scan.raw.data, layout) if self._open_beams else None
