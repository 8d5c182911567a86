# SPDX-License-Identifier: BSD-3-Clause
"""Filter, local map, submaps and graph over a recording, one scan after the other, deterministically."""

import contextlib
import time

import numpy as np

import voxnav
from voxnav.offline.datasets import MAX_WARNINGS, Imu, interpolate_pose
from voxnav.optimizer_session import OptimizerSession, SubmapRecord


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
    """One mapping run. ``configs``: dict of configuration objects by section, see ``voxnav.offline.configs``.

    Frames: O is the origin of the poses that come in, B the body; submaps are posed in W, which is O corrected.
    T_B_L: (4, 4) mount of the LiDAR.
    """

    def __init__(self, configs, T_B_L):
        self._run = configs["run"]
        self._submap_config = configs["submap"]
        self._T_B_L, self._T_L_B = T_B_L, np.linalg.inv(T_B_L)
        self.filter = voxnav.CloudFilter(configs["filter"])
        self.map = voxnav.LocalMap(configs["map"])
        self.scheduler = voxnav.SubmapScheduler(configs["schedule"])
        self.session = OptimizerSession(configs["graph"], configs["optimizer"])
        self.collection = voxnav.SubmapCollection(configs["collection"])
        self.odometry = voxnav.LidarOdometry(configs["odometry"], T_B_L=T_B_L)
        self.stages = Stages()
        self.warnings, self.memory = [], []
        self.stamps, self.poses = [], []
        self.counts = {"scans": 0, "scans_without_pose": 0, "points_in": 0, "points_kept": 0, "submaps": 0, "solves": 0}
        self._early = {}

    def add(self, record):
        """One record of a dataset: an IMU sample or a scan."""
        if isinstance(record, Imu):
            self.odometry.add_imu(np.array([record.stamp]), record.gyro.reshape(1, 3), record.accel.reshape(1, 3))
        else:
            self._add_scan(record)

    def finish(self):
        """Close the open submap and solve once more, with everything."""
        for handover in self.scheduler.finish(self.map):
            self._take(handover)
        with self.stages.time("graph, final solve"):
            report = self.session.optimize(full=True)
        self.counts["solves"] += 1
        self.collection.set_poses(self.session.graph.poses(), self.session.bends())
        return report

    def _add_scan(self, scan):
        with self.stages.time("filter"):
            filtered = self._filter(scan)
        self.counts["points_in"] += filtered.total
        self.counts["points_kept"] += filtered.counts["kept"]
        points, T_O_B = self._located(scan, filtered)
        if T_O_B is None:
            self.counts["scans_without_pose"] += 1
            if len(self.warnings) < MAX_WARNINGS:
                self.warnings.append("scan %.6f left out: no pose" % scan.stamp)
            return
        with self.stages.time("local map"):
            self.map.insert(points, T_O_B @ self._T_B_L)
            if self._run.vehicle_radius_m > 0:
                self.map.mark_free(T_O_B[:3, 3], self._run.vehicle_radius_m)
        with self.stages.time("submap schedule"):
            handovers = self.scheduler.add_scan(self.map, scan.stamp, T_O_B)
        for handover in handovers:
            self._take(handover)
        self.stamps.append(scan.stamp)
        self.poses.append(T_O_B)
        self.counts["scans"] += 1
        self._note_memory(scan.stamp)

    def _filter(self, scan):
        if scan.raw is not None:
            fields = [(f.name, f.offset, f.datatype, f.count) for f in scan.raw.fields]
            layout = voxnav.CloudLayout(scan.raw.height, scan.raw.width, scan.raw.point_step, fields,
                                        row_step=scan.raw.row_step, is_big_endian=bool(scan.raw.is_bigendian))
            return self.filter.apply_raw(scan.raw.data, layout, scan.stamp)
        return self.filter.apply(np.ascontiguousarray(scan.points, dtype=np.float32))

    def _located(self, scan, filtered):
        """Points (n, 3) as seen from one place, and T_O_B there, or None when nothing gives a pose."""
        points = np.ascontiguousarray(filtered.points[:, :3])
        source = self._run.pose_source
        if source == voxnav.PoseSource.RECORDING or (source == voxnav.PoseSource.AUTO and scan.pose is not None):
            return self._deskewed(scan, filtered, points)
        times = filtered.time_offsets_ns * 1e-9
        with self.stages.time("odometry"):
            result = self.odometry.add_cloud(scan.stamp + filtered.sweep_start_s, filtered.points,
                                             times if times.any() else None)
        return points, result.pose

    def _deskewed(self, scan, filtered, points):
        if scan.pose is None:
            return points, None
        offsets, start_s = filtered.time_offsets_ns, filtered.sweep_start_s
        if scan.pose_at is None or not offsets.any():
            return points, scan.pose @ self._T_L_B
        duration_s = 1e-9 * float(offsets.max())
        start, end = scan.pose_at(start_s), scan.pose_at(start_s + duration_s)
        if start is None or end is None:  # odometry begins or ends within the sweep
            return points, scan.pose @ self._T_L_B
        middle = interpolate_pose([0.0, 1.0], [start, end], 0.5)
        return voxnav.deskew(points, offsets, start, end, duration_s), middle @ self._T_L_B

    def _take(self, handover):
        """A part of a submap, or the last of it: then it is filled and put into the graph, which is solved."""
        content = handover.content
        if handover.submap_id in self._early:
            early = self._early.pop(handover.submap_id)
            early.merge(content)
            content = early
        if not handover.is_final:
            self._early[handover.submap_id] = content
            return
        with self.stages.time("submap fill"):
            submap = voxnav.Submap.from_content(content, np.linalg.inv(handover.T_O_S), self._submap_config)
        stamps = handover.pose_stamps
        with self.stages.time("graph"):
            self.session.add_submap(SubmapRecord(handover.submap_id, stamps[0], stamps[-1], handover.T_O_S, stamps,
                                                 handover.T_S_B), submap.registration_field(stamps, handover.T_S_B))
            self.session.optimize()
        poses = self.session.graph.poses()
        with self.stages.time("collection"):
            self.collection.add(handover.submap_id, submap, poses[handover.submap_id], stamps[-1])
            self.collection.set_poses(poses, self.session.bends())
        self.counts["submaps"] += 1
        self.counts["solves"] += 1

    def _note_memory(self, stamp):
        time_s = stamp - self.stamps[0]
        if self.memory and time_s - self.memory[-1]["time_s"] < 1.0:
            return
        self.memory.append({"time_s": time_s, "process_mb": voxnav.process_usage()["rss_bytes"] * 1e-6,
                            "local_map_mb": self.map.memory_bytes * 1e-6,
                            "submaps_mb": self.collection.memory_bytes * 1e-6})
