# SPDX-License-Identifier: BSD-3-Clause
"""A submap graph to which submaps and measurements are added as they arrive: the submap_optimizer node without ROS.

Frames: W map, O odometry origin, B body, S submap, G frame of the GNSS positions. Stamps are seconds.
"""

from __future__ import annotations

import collections
import math
from typing import Any, Iterable, NamedTuple

import numpy as np

import voxnav
from voxnav.array_types import Array


class SubmapRecord(NamedTuple):
    """A finished submap. stamps_s (n,) rising and T_S_B (n, 4, 4) are its pose history."""

    id: int
    start_s: float
    end_s: float
    T_O_S: Array
    stamps_s: Array
    T_S_B: Array


class Loop(NamedTuple):
    """A loop closure between two bodies. T_A_B (4, 4); covariance (6, 6) of its x y z roll pitch yaw."""

    stamp_a_s: float
    stamp_b_s: float
    T_A_B: Array
    covariance: Array


class Fix(NamedTuple):
    """A GNSS position p_G (3,) in metres with its (3, 3) covariance."""

    stamp_s: float
    p_G: Array
    covariance: Array


class Height(NamedTuple):
    """A height above any fixed level."""

    stamp_s: float
    height_m: float


def body_pose_at(record: SubmapRecord, stamp_s: float) -> Array | None:
    """Returns the gravity-aligned T_S_B at a time, or None outside of the pose history."""
    stamps = record.stamps_s
    if len(stamps) == 0 or not stamps[0] <= stamp_s <= stamps[-1]:
        return None
    i = min(int(np.searchsorted(stamps, stamp_s, side="right")), len(stamps) - 1)
    before, after = record.T_S_B[max(i - 1, 0)], record.T_S_B[i]
    span = stamps[i] - stamps[max(i - 1, 0)]
    ratio = (stamp_s - stamps[max(i - 1, 0)]) / span if span > 0.0 else 1.0
    return voxnav.gravity_aligned(voxnav.interpolate_pose(before, after, ratio))


def _known_pose(record: SubmapRecord, stamp_s: float) -> Array:
    """Returns body_pose_at() of a time that lies within the pose history."""
    T_S_B = body_pose_at(record, stamp_s)
    if T_S_B is None:
        raise LookupError("submap %d has no pose at %.6f" % (record.id, stamp_s))
    return T_S_B


def loop_between_submaps(T_SA_A: Array, T_SB_B: Array, T_A_B: Array, covariance: Array) -> tuple[Array, Array]:
    """Converts a loop between bodies to one between their submaps: T_Sa_Sb and its (4, 4) information.

    covariance: (6, 6) of x y z roll pitch yaw of T_A_B. The heading error of the loop moves the far submap too.
    """
    T_B_SB = np.linalg.inv(T_SB_B)
    rotation, lever = T_SA_A[:3, :3], T_A_B[:3, :3] @ T_B_SB[:3, 3]
    jacobian = np.eye(4)
    jacobian[:3, :3] = rotation
    jacobian[:3, 3] = rotation @ np.array([-lever[1], lever[0], 0.0])
    rows = [0, 1, 2, 5]
    spread = jacobian @ covariance[np.ix_(rows, rows)] @ jacobian.T
    information = np.linalg.inv(0.5 * (spread + spread.T))
    return voxnav.gravity_aligned(T_SA_A @ T_A_B @ T_B_SB), 0.5 * (information + information.T)


class OptimizerSession:
    """Builds a SubmapGraph from submaps, loop closures, GNSS and heights as they arrive.

    Not thread-safe, except that add_fix and add_height may be called while another thread does the rest.
    """

    def __init__(self, graph_config: voxnav.SubmapGraphConfig | None = None,
                 config: voxnav.OptimizerConfig | None = None) -> None:
        self.config = config or voxnav.OptimizerConfig()
        voxnav.set_distance_cache_mb(self.config.distance_cache_mb)
        self._graph = voxnav.SubmapGraph(graph_config or voxnav.SubmapGraphConfig())
        self._records: collections.OrderedDict[int, SubmapRecord] = collections.OrderedDict()
        self._loops: collections.deque[Loop] = collections.deque()
        self._fixes: collections.deque[Fix] = collections.deque(maxlen=self.config.max_pending)
        self._heights: collections.deque[Height] = collections.deque(maxlen=self.config.max_pending)
        self._height_offset: float | None = None
        self.T_W_O = np.eye(4)
        self.revision = 0
        self.dropped: collections.Counter[str] = collections.Counter()

    @property
    def records(self) -> collections.OrderedDict[int, SubmapRecord]:
        """The submaps by id, oldest first."""
        return self._records

    @property
    def graph(self) -> voxnav.SubmapGraph:
        return self._graph

    def add_submap(self, record: SubmapRecord, field: voxnav.DistanceField | None = None) -> bool:
        """Adds a finished submap at the pose that odometry since the last one gives. False if it is known already.

        field: DistanceField by which it is registered. Raises ValueError for a pose that is not valid, if the graph is
        full, and for a known id with another time (of an integrator that was restarted).
        """
        if record.id in self._records:
            if abs(self._records[record.id].start_s - record.start_s) > 1e-3:
                raise ValueError("submap %d is known from another time; restart the optimiser too" % record.id)
            return False
        previous = next(reversed(self._records.values())) if self._records else None
        self._graph.add_submap(record.id, voxnav.gravity_aligned(self.T_W_O @ record.T_O_S), field)
        self._records[record.id] = record
        if previous is not None:
            T_a_b = voxnav.gravity_aligned(np.linalg.inv(previous.T_O_S) @ record.T_O_S)
            gap_s = max(0.0, record.start_s - previous.start_s)
            self._graph.add_relative_pose(previous.id, record.id, T_a_b, self._odometry_information(gap_s),
                                          voxnav.ConstraintKind.ODOMETRY)
        self._attach_fixes(record)
        self._attach_heights(record)
        self._attach_loops()
        return True

    def add_loop(self, loop: Loop) -> None:
        """Adds a loop closure between two stamps, which waits until both lie in finished submaps.

        Raises ValueError if it cannot be used.
        """
        if not (np.all(np.isfinite(loop.T_A_B)) and np.all(np.isfinite(loop.covariance))):
            raise ValueError("loop closure is not finite")
        if np.any(np.linalg.eigvalsh(loop.covariance[np.ix_([0, 1, 2, 5], [0, 1, 2, 5])]) <= 0.0):
            raise ValueError("covariance of x, y, z, yaw must be positive definite")
        if len(self._loops) >= self.config.max_pending:
            self._loops.popleft()
            self.dropped["loop"] += 1
        self._loops.append(loop)
        self._attach_loops()

    def add_fix(self, fix: Fix) -> bool:
        """Adds a GNSS position in frame G, used once the submap of its time is finished. False if too uncertain."""
        if not (np.all(np.isfinite(fix.p_G)) and np.all(np.isfinite(fix.covariance))):
            self.dropped["gnss"] += 1
            return False
        if math.sqrt(max(np.linalg.eigvalsh(fix.covariance)[-1], 0.0)) > self.config.gnss_max_sigma_m:
            self.dropped["gnss"] += 1
            return False
        self._fixes.append(fix)
        return True

    def add_height(self, height: Height) -> bool:
        """Adds a height above any fixed level; only its changes matter."""
        if not math.isfinite(height.height_m):
            self.dropped["height"] += 1
            return False
        self._heights.append(height)
        return True

    def optimize(self, full: bool = False) -> voxnav.OptimizeReport:
        """Solves and sets T_W_O so that the newest submap does not move in O. Returns an OptimizeReport."""
        report = self._graph.optimize(full=full)
        if self._records:
            newest = next(reversed(self._records.values()))
            T_S_O = np.linalg.inv(voxnav.gravity_aligned(newest.T_O_S))
            self.T_W_O = voxnav.gravity_aligned(self._graph.poses()[newest.id] @ T_S_O)
        self.revision += 1
        return report

    def change_origin(self, T_new_old: Array) -> None:
        """Expresses the odometry so far in another origin O, so that relative poses to what comes next are right.

        T_new_old: (4, 4) transform from the present origin to the new one. The map, W, does not move.
        """
        for number, record in self._records.items():
            self._records[number] = record._replace(T_O_S=T_new_old @ record.T_O_S)
        self.T_W_O = voxnav.gravity_aligned(self.T_W_O @ np.linalg.inv(T_new_old))

    def trajectory(self) -> tuple[Array, Array]:
        """Returns stamps (n,) and poses T_W_B (n, 4, 4) of the flight so far, without steps, thinned to the limit."""
        records = [r for r in self._records.values() if len(r.stamps_s)]
        if not records:
            return np.empty(0), np.empty((0, 4, 4))
        stamps = np.concatenate([r.stamps_s for r in records])
        T_O_B = np.concatenate([r.T_O_S @ r.T_S_B for r in records])
        step = -(-len(stamps) // self.config.max_trajectory_poses)
        stamps, T_O_B = np.ascontiguousarray(stamps[::step]), np.ascontiguousarray(T_O_B[::step])
        return stamps, voxnav.correct_trajectory(stamps, T_O_B, *self._corrections(records)[1:])

    def bends(self) -> dict[int, Array]:
        """Returns {id: (2, 4, 4)}, the drift within each submap; see voxnav.submap_bends()."""
        ids, spans_s, T_O_S, T_W_S = self._corrections(self._records.values())
        return dict(zip(ids, voxnav.submap_bends(spans_s, T_O_S, T_W_S, self.config.max_bend_m))) if ids else {}

    def _corrections(self, records: Iterable[SubmapRecord]) -> tuple[list[int], Array, Array, Array]:
        """Returns ids, time spans (k, 2), T_O_S and T_W_S (k, 4, 4) of the submaps whose middles rise in time."""
        poses, kept, last_s = self._graph.poses(), [], -math.inf
        for record in records:
            middle_s = 0.5 * (record.start_s + record.end_s)
            if middle_s > last_s + 1e-6:
                kept.append(record)
                last_s = middle_s
        return ([r.id for r in kept], np.array([(r.start_s, r.end_s) for r in kept]),
                np.array([voxnav.gravity_aligned(r.T_O_S) for r in kept]), np.array([poses[r.id] for r in kept]))

    def _odometry_information(self, gap_s: float) -> Array:
        c = self.config
        xy = math.hypot(c.odometry_xy_m, c.odometry_xy_mps * gap_s)
        z = math.hypot(c.odometry_z_m, c.odometry_z_mps * gap_s)
        yaw = math.hypot(c.odometry_yaw_rad, c.odometry_yaw_radps * gap_s)
        return np.diag([xy ** -2, xy ** -2, z ** -2, yaw ** -2])

    def _attach_fixes(self, record: SubmapRecord) -> None:
        lever = np.array(self.config.gnss_lever_arm_m)
        for fix in _take_spread(self._fixes, record, self.config.gnss_per_submap):
            p_S = (_known_pose(record, fix.stamp_s) @ np.append(lever, 1.0))[:3]
            covariance = fix.covariance + np.eye(3) * self.config.gnss_min_sigma_m ** 2
            self._graph.add_gnss_position(record.id, p_S, fix.p_G, covariance)

    def _attach_heights(self, record: SubmapRecord) -> None:
        for height in _take_spread(self._heights, record, self.config.heights_per_submap):
            p_S = _known_pose(record, height.stamp_s)[:3, 3]
            if self._height_offset is None:
                # The level of the heights is whatever makes the first one agree with the map.
                self._height_offset = (self._graph.poses()[record.id] @ np.append(p_S, 1.0))[2] - height.height_m
            self._graph.add_height(record.id, p_S, height.height_m + self._height_offset, self.config.height_sigma_m)

    def _attach_loops(self) -> None:
        waiting: collections.deque[Loop] = collections.deque()
        newest_s = next(reversed(self._records.values())).end_s if self._records else -math.inf
        for loop in self._loops:
            a, b = self._record_at(loop.stamp_a_s), self._record_at(loop.stamp_b_s)
            if a is None or b is None:
                if max(loop.stamp_a_s, loop.stamp_b_s) > newest_s:
                    waiting.append(loop)
                else:
                    self.dropped["loop"] += 1
            elif a.id == b.id:
                self.dropped["loop"] += 1
            else:
                T_a_b, information = loop_between_submaps(_known_pose(a, loop.stamp_a_s),
                                                          _known_pose(b, loop.stamp_b_s), loop.T_A_B, loop.covariance)
                self._graph.add_relative_pose(a.id, b.id, T_a_b, information, voxnav.ConstraintKind.LOOP)
        self._loops = waiting

    def _record_at(self, stamp_s: float) -> SubmapRecord | None:
        for record in reversed(self._records.values()):
            if body_pose_at(record, stamp_s) is not None:
                return record
        return None


def _take_spread(pending: collections.deque[Any], record: SubmapRecord, limit: int) -> list[Any]:
    """Removes the measurements up to the end of a submap from `pending`. Returns up to `limit` of those of its time.

    They are spread evenly over time.
    """
    inside = []
    while pending and pending[0].stamp_s <= record.end_s:
        measurement = pending.popleft()
        if body_pose_at(record, measurement.stamp_s) is not None:
            inside.append(measurement)
    if len(inside) <= limit:
        return inside
    return [inside[i] for i in np.linspace(0, len(inside) - 1, limit).round().astype(int)] if limit else []
