# SPDX-License-Identifier: BSD-3-Clause
"""Runs filter, local map, submaps and graph over a recording, one scan after another, deterministically."""

from __future__ import annotations

import contextlib
import time
from typing import Any, Iterator, Sequence

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.offline.configs import sensor_configs
from voxnav.offline.coverage import Coverage
from voxnav.offline.datasets import MAX_WARNINGS, Imu, Odometry, Scan
from voxnav.offline.pose_gaps import PoseGaps, TrackedPose
from voxnav.offline.sensors import MountedSensor, SensorInput
from voxnav.optimizer_session import OptimizerSession, SubmapRecord
from voxnav.recordings.left_out import LeftOut


class Stages:
    """The wall and CPU time of every stage, in constant memory."""

    def __init__(self) -> None:
        self._stages: dict[str, voxnav.StageStatistics] = {}

    @contextlib.contextmanager
    def time(self, name: str) -> Iterator[None]:
        wall, cpu = time.monotonic(), time.process_time()
        try:
            yield
        finally:
            self._stages.setdefault(name, voxnav.StageStatistics()).add(
                1e3 * (time.monotonic() - wall), 1e3 * (time.process_time() - cpu))

    def summary(self) -> dict[str, Any]:
        out = {name: stage.summary() for name, stage in self._stages.items()}
        for numbers in out.values():
            for key in ("latency_mean_ms", "latency_p99_ms"):  # a recording has no latency
                numbers.pop(key)
        return out


def _reasons(counts: dict[str, int]) -> str:
    """Returns the reasons for which the points of a cloud were removed, with their counts."""
    return ", ".join("%s %d" % (name, count) for name, count in sorted(counts.items()) if count)


def _record_of(finished: voxnav.FinishedSubmap) -> SubmapRecord:
    """Returns a FinishedSubmap as a record for the graph, with its poses as they would arrive at the optimiser node."""
    poses = np.array([voxnav.as_sent(T) for T in finished.T_S_B]).reshape(-1, 4, 4)
    return SubmapRecord(finished.submap_id, finished.start, finished.stamp, voxnav.as_sent(finished.T_O_S),
                        finished.pose_stamps, poses)


class OfflineMapper:
    """One mapping run. ``configs``: dict of configuration objects by section, see ``voxnav.offline.configs``.

    Frames: O is the origin of the input poses, B the body; the poses of submaps are in W, the corrected frame.
    lidar: the sensor that LiDAR odometry follows. has_poses: whether the recording has poses; else LiDAR odometry
    estimates them. further: other sensors whose scans are mapped, too.
    """

    def __init__(self, configs: dict[str, Any], lidar: MountedSensor, has_poses: bool,
                 further: Sequence[MountedSensor] = ()) -> None:
        source = configs["run"].pose_source
        self._uses_odometry = source == voxnav.PoseSource.LIDAR or (source == voxnav.PoseSource.AUTO and not has_poses)
        self._assembler = voxnav.SubmapAssembler(configs["submap"])
        self.sensors = [SensorInput(number, sensor, sensor_configs(configs, sensor.topic))
                        for number, sensor in enumerate([lidar] + list(further))]
        T_B_L = self.sensors[0].T_B_L
        # With "auto" the recorded poses are used, and LiDAR odometry fills their gaps. Without any it gives all poses.
        covers_gaps = source == voxnav.PoseSource.AUTO and not self._uses_odometry
        self.gaps = PoseGaps(configs["odometry"] if covers_gaps else None, T_B_L, configs["mapper"].max_pose_gap_s)
        self.left_out = LeftOut()
        self.page: list[str] = []  # the description of the recording, for people
        self.origin_m: Array | None = None  # was subtracted from the positions of the recording; None: nothing was
        self.mapper = voxnav.Mapper(self._mapper_config(configs), T_B_L)
        for sensor in self.sensors[1:]:
            self.mapper.set_mount(sensor.number, sensor.T_B_L)
        self.session = OptimizerSession(configs["graph"], configs["optimizer"])
        self.collection = voxnav.SubmapCollection(configs["collection"])
        self._has_ended = False
        self.stages = Stages()
        self.warnings: list[str] = []
        self.memory: list[dict[str, float]] = []
        self.stamps: list[float] = []
        self.poses: list[Array] = []
        self.counts = {"scans": 0, "scans_without_pose": 0, "points_in": 0, "points_kept": 0, "submaps": 0, "solves": 0}

    def _mapper_config(self, configs: dict[str, Any]) -> voxnav.MapperConfig:
        out: voxnav.MapperConfig = configs["mapper"]
        out.map, out.moving, out.submap = configs["map"], configs["moving"], configs["schedule"]
        out.odometry = configs["odometry"] if self._uses_odometry else None
        out.sensors = [sensor.limits for sensor in self.sensors]
        return out

    @property
    def coverage(self) -> Coverage:
        """That of the sensor of which most is missing."""
        return min((sensor.coverage for sensor in self.sensors), key=lambda found: (found.is_enough, found.share))

    @property
    def map(self) -> voxnav.LocalMap:
        """Returns the local map."""
        return self.mapper.map

    def add(self, record: Imu | Odometry | Scan) -> None:
        """Adds one record of a dataset: an IMU sample, a pose of the body or a scan."""
        if isinstance(record, Imu):
            self._add_imu(record)
        elif isinstance(record, Odometry):
            T_O_B = voxnav.pose_from_quaternion(record.position, record.q_xyzw)
            self._add_poses(self.gaps.add_pose(record.stamp_ns, T_O_B))
            self._add_poses([TrackedPose(record.stamp_ns, T_O_B)])
        else:
            self._add_scan(record)
        self._map_ready()

    def expect_imu(self) -> None:
        """Makes scans wait until the IMU has shown the vertical to LiDAR odometry, as the recording has an IMU."""
        self.mapper.expect_imu()

    def end_input(self) -> None:
        """Maps the scans that still wait, because no more records will come."""
        if self._has_ended:
            return
        self._has_ended = True
        self.gaps.end()
        self.mapper.end_input()
        self._map_ready()

    def finish(self) -> voxnav.OptimizeReport:
        """Closes the open submap and solves once more, with all submaps."""
        self.end_input()
        for handover in self.mapper.finish():
            self._take(handover)
        times = [sensor.filter.point_times.problem for sensor in self.sensors]
        for problem in times + self.mapper.odometry_problems:
            if problem:
                self._warn(problem)
        with self.stages.time("graph, final solve"):
            report = self.session.optimize(full=True)
        self.counts["solves"] += 1
        self._place_submaps()
        return report

    def _add_imu(self, imu: Imu) -> None:
        timer = self.stages.time("odometry") if self.mapper.is_waiting_for_imu else contextlib.nullcontext()
        with timer:
            self.mapper.add_imu(np.array([imu.stamp_ns]), imu.gyro.reshape(1, 3), imu.accel.reshape(1, 3))
            self.gaps.add_imu(imu)

    def _add_poses(self, poses: list[TrackedPose]) -> None:
        for pose in poses:
            if not self.mapper.add_pose(pose.stamp_ns, pose.T):
                self.left_out.add("odometry", "its stamp is not newer than the one before", pose.stamp_ns)

    def _add_scan(self, scan: Scan) -> None:
        """Adds a scan to the mapper. A cloud that cannot be read, or has no points left, is only counted."""
        sensor = self.sensors[scan.sensor]
        try:
            with self.stages.time("filter"):
                filtered, sweep = sensor.sweep(scan, self.stages.time)
        except ValueError as error:
            return self._leave_out(sensor, 1e-9 * scan.stamp_ns, str(error))
        if not len(sweep.points) and not len(sweep.open_beams):
            return self._leave_out(sensor, 1e-9 * scan.stamp_ns, "it has no points" if not filtered.total else
                                   "the filter keeps none of its points (%s)" % _reasons(filtered.counts))
        self.counts["points_in"] += filtered.total
        self.counts["points_kept"] += filtered.counts["kept"]
        timer = self.stages.time("odometry") if self._uses_odometry else contextlib.nullcontext()
        with timer:
            if not self._uses_odometry and scan.T_O_L is None and sensor.number == 0:
                self._add_poses(self.gaps.add_sweep(sweep))
            T_O_L = None if self._uses_odometry else scan.T_O_L
            self.mapper.queue_sweep(sweep, None if T_O_L is None else T_O_L @ sensor.T_L_B)

    def _map_ready(self) -> None:
        """Maps the scans whose poses are known by now."""
        while self.mapper.has_next():
            with self.stages.time("local map"):
                step = self.mapper.next()
            for handover in step.handovers:
                self._take(handover)
            if step.map_cleared:
                self._warn("map cleared at %.6f: %s" % (step.stamp, step.map_cleared))
            if step.fate == voxnav.SweepFate.MAPPED:
                self._note(step)
            elif step.fate == voxnav.SweepFate.SURPLUS:
                # It is left out on purpose, so that the map covers its time without it.
                self.left_out.add(self.sensors[step.sensor].what, step.reason, int(1e9 * step.stamp))
            else:
                self.counts["scans_without_pose"] += 1
                self._leave_out(self.sensors[step.sensor], step.stamp, step.reason)

    def _note(self, step: Any) -> None:
        with self.stages.time("submap schedule"):
            handovers = self.mapper.close_due()
        for handover in handovers:
            self._take(handover)
        self.counts["scans"] += 1
        self.sensors[step.sensor].coverage.add(step.stamp, True)
        if step.leads:
            self.stamps.append(step.stamp)
            self.poses.append(step.T_O_B)
            self._note_memory(step.stamp)

    def _leave_out(self, sensor: SensorInput, stamp_s: float, reason: str) -> None:
        sensor.coverage.add(stamp_s, False)
        self.left_out.add(sensor.what, reason, int(1e9 * stamp_s))

    def _warn(self, text: str) -> None:
        if len(self.warnings) < MAX_WARNINGS:
            self.warnings.append(text)

    def _take(self, handover: voxnav.Handover) -> None:
        """Takes a handover. The last part of a submap completes it; it is then added to the graph, which is solved."""
        with self.stages.time("submap fill"):
            result = self._assembler.add(handover.as_sent())
        if result.dropped:
            self._warn(result.dropped)
        if result.submap is None:
            return
        finished = result.submap
        with self.stages.time("graph"):
            record = _record_of(finished)
            self.session.add_submap(record, finished.submap.registration_field(record.stamps_s, record.T_S_B))
            self.session.optimize()
        with self.stages.time("collection"):
            self.collection.add_finished(finished)
            self._place_submaps()
        self.counts["submaps"] += 1
        self.counts["solves"] += 1

    def _place_submaps(self) -> None:
        """Moves the submaps to their optimised poses, as they would arrive from the node, so that maps are equal."""
        poses = {i: voxnav.as_sent(T) for i, T in self.session.graph.poses().items()}
        bends = {i: np.array([voxnav.as_sent(T) for T in ends]) for i, ends in self.session.bends().items()}
        self.collection.set_poses(poses, bends)

    def _note_memory(self, stamp: float) -> None:
        time_s = stamp - self.stamps[0]
        if self.memory and time_s - self.memory[-1]["time_s"] < 1.0:
            return
        self.memory.append({"time_s": time_s, "process_mb": voxnav.process_usage()["rss_bytes"] * 1e-6,
                            "local_map_mb": self.map.memory_bytes * 1e-6,
                            "submaps_mb": self.collection.memory_bytes * 1e-6})
