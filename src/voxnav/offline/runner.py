# SPDX-License-Identifier: BSD-3-Clause
"""Filter, local map, submaps and graph over a recording, one scan after the other, deterministically."""

import contextlib
import time

import numpy as np

import voxnav
from voxnav.offline.datasets import Imu


class Stages:
    """Wall and CPU time of every stage, in constant memory."""

    def __init__(self):
        self._stages = {}

    @contextlib.contextmanager
    def time(self, name):
        wall, cpu = time.monotonic(), time.process_time()
        try:
            yield
        finally:
            self._stages.setdefault(name, voxnav.StageStatistics()).add(
                1e3 * (time.monotonic() - wall), 1e3 * (time.process_time() - cpu))

    def summary(self):
        out = {name: stage.summary() for name, stage in self._stages.items()}
        for numbers in out.values():
            for key in ("latency_mean_ms", "latency_p99_ms"):  # a recording has no latency
                numbers.pop(key)
        return out


class OfflineMapper:
    """One mapping run. ``configs``: dict of configuration objects, see voxnav.offline.configs.

    Frames: O is the origin of the poses that come in, B the body; submaps are posed in W, which is O corrected.
    """

    def __init__(self, configs):
        self._run = configs["run"]
        self.filter = voxnav.CloudFilter(configs["filter"])
        self.map = voxnav.LocalMap(configs["map"])
        self.scheduler = voxnav.SubmapScheduler(configs["schedule"])
        self.graph = voxnav.SubmapGraph(configs["graph"])
        self.collection = voxnav.SubmapCollection(configs["collection"])
        self.odometry = voxnav.LidarOdometry(configs["odometry"])
        self._submap_config = configs["submap"]
        self.stages = Stages()
        self.warnings, self.memory = [], []
        self.stamps, self.odometry_poses = [], []
        self.counts = {"scans": 0, "scans_without_pose": 0, "points_in": 0, "points_kept": 0, "submaps": 0}
        self._last = None

    def add(self, record, T_B_L):
        """One record of a dataset: an IMU sample or a scan. T_B_L: (4, 4) mount of the LiDAR."""
        if isinstance(record, Imu):
            if self._uses_lidar(None):
                self.odometry.add_imu(np.array([record.stamp]), record.gyro.reshape(1, 3), record.accel.reshape(1, 3))
            return
        self._add_scan(record, T_B_L)

    def _uses_lidar(self, pose):
        source = self._run.pose_source
        return source == "lidar" or (source == "auto" and pose is None)

    def _add_scan(self, scan, T_B_L):
        with self.stages.time("filter"):
            filtered = self._filter(scan)
        self.counts["points_in"] += filtered.total
        self.counts["points_kept"] += filtered.counts["kept"]
        T_O_L = self._pose(scan, filtered)
        if T_O_L is None:
            self.counts["scans_without_pose"] += 1
            return
        points = np.ascontiguousarray(filtered.points[:, :3])
        with self.stages.time("local map"):
            self.map.insert(points, T_O_L)
            if self._run.vehicle_radius_m > 0:
                self.map.mark_free(T_O_L[:3, 3], self._run.vehicle_radius_m)
        T_O_B = T_O_L @ np.linalg.inv(T_B_L)
        with self.stages.time("submap schedule"):
            handovers = self.scheduler.add_scan(self.map, scan.stamp, T_O_B)
        for handover in handovers:
            self._close(handover)
        self.stamps.append(scan.stamp)
        self.odometry_poses.append(T_O_B)
        self.counts["scans"] += 1
        self._note_memory(scan.stamp)

    def _filter(self, scan):
        if scan.raw is not None:
            layout = voxnav.CloudLayout(scan.raw.height, scan.raw.width, scan.raw.point_step,
                                        [(f.name, f.offset, f.datatype, f.count) for f in scan.raw.fields])
            return self.filter.apply_raw(scan.raw.data, layout, scan.stamp)
        points = scan.points if scan.points.ndim == 3 else scan.points.reshape(1, -1, 4)
        return self.filter.apply(np.ascontiguousarray(points, dtype=np.float32))

    def _pose(self, scan, filtered):
        """T_O_L of the scan, or None when nothing gives one."""
        if not self._uses_lidar(scan.pose):
            if scan.pose is None:
                self.warnings.append("scan %.6f left out: no pose" % scan.stamp)
            return scan.pose
        with self.stages.time("odometry"):
            result = self.odometry.add_cloud(scan.stamp, np.ascontiguousarray(filtered.points), filtered.times)
        return result.pose

    def _close(self, handover):
        """A submap is complete: fill it, put it into the graph, solve."""
        if not handover.is_final:
            return
        with self.stages.time("submap fill"):
            submap = voxnav.Submap.from_content(handover.content, handover.T_O_S, self._submap_config)
        T_W_S = self.graph.add_odometry_submap(handover.submap_id, handover.T_O_S, submap)
        with self.stages.time("graph"):
            self.graph.optimize()
        with self.stages.time("collection"):
            self.collection.add(handover, submap, T_W_S)
            self.collection.set_poses(self.graph.poses())
        self.counts["submaps"] += 1

    def _note_memory(self, stamp):
        if self.memory and stamp - self.memory[-1]["time_s"] - self.stamps[0] < 1.0:
            return
        mega = 1e-6
        self.memory.append({
            "time_s": stamp - self.stamps[0],
            "process_mb": voxnav.process_usage()["rss_bytes"] * mega,
            "local_map_mb": self.map.memory_bytes * mega,
            "submaps_mb": self.collection.memory_bytes * mega,
        })
