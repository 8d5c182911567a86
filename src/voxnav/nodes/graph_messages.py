# SPDX-License-Identifier: BSD-3-Clause
"""Conversions between messages and the inputs and outputs of the submap optimiser."""

import math

import numpy as np
import rospy
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import Path
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

import voxnav
from voxnav import ConstraintKind
from voxnav.msg import OptimizerReport, SubmapPoses
from voxnav.nodes.poses import pose_from_msg, pose_to_msg
from voxnav.optimizer_session import Fix, Loop, SubmapRecord

KINDS = tuple(ConstraintKind)
_COLOURS = {ConstraintKind.ODOMETRY: (0.2, 0.4, 1.0), ConstraintKind.REGISTRATION: (0.2, 0.8, 0.2),
            ConstraintKind.LOOP: (1.0, 0.8, 0.1), ConstraintKind.GNSS: (0.7, 0.2, 0.9),
            ConstraintKind.HEIGHT: (0.5, 0.5, 0.5)}
_BAD_SIGMAS = 5.0  # a constraint this far off is drawn red

_EARTH_RADIUS_M, _EARTH_E2 = 6378137.0, 6.69437999014e-3  # WGS84


def seconds_of(stamp):
    """Converts a stamp to seconds with the same rounding as the core; rospy adds seconds and their fraction instead."""
    return 1e-9 * stamp.to_nsec()


def record_from_msg(msg):
    """Returns the SubmapRecord of a voxnav/FinishedSubmap. Raises ValueError if poses or stamps are not usable."""
    if len(msg.pose_stamps) != len(msg.T_S_B):
        raise ValueError("submap %d has %d stamps for %d poses" % (msg.submap_id, len(msg.pose_stamps), len(msg.T_S_B)))
    stamps = np.array([seconds_of(stamp) for stamp in msg.pose_stamps])
    if np.any(np.diff(stamps) < 0.0):
        raise ValueError("submap %d has stamps that go back" % msg.submap_id)
    poses = np.array([pose_from_msg(pose) for pose in msg.T_S_B]).reshape(-1, 4, 4)
    return SubmapRecord(msg.submap_id, seconds_of(msg.start), seconds_of(msg.header.stamp), pose_from_msg(msg.T_O_S),
                        stamps, poses)


def field_from_msg(msg, record):
    """Returns the DistanceField of a submap; None if the message has none. Raises ValueError for damaged bytes."""
    if not len(msg.data):
        return None
    return voxnav.Submap.from_bytes(bytes(msg.data)).registration_field(record.stamps_s, record.T_S_B)


def loop_from_msg(msg):
    covariance = np.array(msg.covariance).reshape(6, 6)
    return Loop(msg.stamp_a.to_sec(), msg.stamp_b.to_sec(), pose_from_msg(msg.T_A_B), covariance)


def fix_from_odometry(msg):
    p = msg.pose.pose.position
    covariance = np.array(msg.pose.covariance).reshape(6, 6)[:3, :3]
    return Fix(msg.header.stamp.to_sec(), np.array([p.x, p.y, p.z]), covariance)


def _earth_fixed(latitude_rad, longitude_rad, altitude_m):
    n = _EARTH_RADIUS_M / math.sqrt(1.0 - _EARTH_E2 * math.sin(latitude_rad) ** 2)
    across = (n + altitude_m) * math.cos(latitude_rad)
    return np.array([across * math.cos(longitude_rad), across * math.sin(longitude_rad),
                     (n * (1.0 - _EARTH_E2) + altitude_m) * math.sin(latitude_rad)])


class FixReader:
    """Converts NavSatFix messages to metres east, north and up of the first fix (WGS84)."""

    def __init__(self):
        self._origin = None

    def read(self, msg):
        """Returns a Fix, or None if the receiver has none or does not tell its covariance."""
        values = (msg.latitude, msg.longitude, msg.altitude)
        if msg.status.status < 0 or msg.position_covariance_type == 0 or not all(map(math.isfinite, values)):
            return None
        latitude, longitude = math.radians(msg.latitude), math.radians(msg.longitude)
        position = _earth_fixed(latitude, longitude, msg.altitude)
        if self._origin is None:
            sa, ca, so, co = math.sin(latitude), math.cos(latitude), math.sin(longitude), math.cos(longitude)
            rotation = np.array([[-so, co, 0.0], [-sa * co, -sa * so, ca], [ca * co, ca * so, sa]])
            self._origin = (position, rotation)
        origin, rotation = self._origin
        covariance = np.array(msg.position_covariance).reshape(3, 3)
        return Fix(msg.header.stamp.to_sec(), rotation @ (position - origin), covariance)


def poses_to_msg(session, stamp, map_frame):
    poses, bends = session.graph.poses(), session.bends()
    begins, ends = ([pose_to_msg(bends[i][k] if i in bends else np.eye(4)) for i in poses] for k in (0, 1))
    return SubmapPoses(header=Header(stamp=stamp, frame_id=map_frame), revision=session.revision,
                       submap_ids=list(poses), T_W_S=[pose_to_msg(T) for T in poses.values()], T_S_begin=begins,
                       T_S_end=ends, T_W_O=pose_to_msg(session.T_W_O))


def report_to_msg(report, session, stamp, map_frame, solve_s):
    out = OptimizerReport(header=Header(stamp=stamp, frame_id=map_frame), revision=session.revision, kinds=list(KINDS))
    out.is_converged, out.iterations, out.num_submaps = report.is_converged, report.iterations, report.num_submaps
    out.solve_s, out.cpu_s = solve_s, report.seconds
    out.num_constraints = [report.num_constraints[kind] for kind in KINDS]
    out.cost_before = [report.costs_before[kind] for kind in KINDS]
    out.cost_after = [report.costs[kind] for kind in KINDS]
    out.num_rejected_loops = len(report.rejected_loops)
    out.rejections = ["loop %d - %d %s" % rejected for rejected in report.rejected_loops[:100]]
    return out


def trajectory_to_msg(session, stamp, map_frame):
    header = Header(stamp=stamp, frame_id=map_frame)
    stamps, poses = session.trajectory()
    return Path(header=header, poses=[
        PoseStamped(header=Header(stamp=rospy.Time.from_sec(s), frame_id=map_frame), pose=pose_to_msg(T))
        for s, T in zip(stamps, poses)])


def _colour(kind, cost):
    """Returns the colour of a constraint's kind, which turns red with the residual."""
    share = min(math.sqrt(max(cost, 0.0)) / _BAD_SIGMAS, 1.0)
    r, g, b = _COLOURS[kind]
    return ColorRGBA(r + share * (1.0 - r), g * (1.0 - share), b * (1.0 - share), 0.9)


def markers_to_msg(session, stamp, map_frame, max_lines):
    """Makes markers of submaps (spheres) and constraints between two of them (lines): the newest ones of each kind."""
    header = Header(stamp=stamp, frame_id=map_frame)
    points = {i: Point(*T[:3, 3]) for i, T in session.graph.poses().items()}
    spheres = Marker(header=header, ns="submaps", type=Marker.SPHERE_LIST, points=list(points.values()))
    spheres.scale.x = spheres.scale.y = spheres.scale.z = 0.8
    spheres.color = ColorRGBA(1.0, 1.0, 1.0, 0.9)
    lines = {}
    for kind in (ConstraintKind.ODOMETRY, ConstraintKind.REGISTRATION, ConstraintKind.LOOP):
        lines[kind] = Marker(header=header, ns=kind, type=Marker.LINE_LIST)
        lines[kind].scale.x = 0.15
    between = [c for c in session.graph.constraints() if c[0] in lines and c[4]]
    between.sort(key=lambda c: max(c[1], c[2]))
    for kind, a, b, cost, _ in between[-max_lines:]:
        lines[kind].points += [points[a], points[b]]
        lines[kind].colors += [_colour(kind, cost)] * 2
    out = [spheres] + list(lines.values())
    for marker in out:
        marker.pose.orientation.w = 1.0
        marker.action = Marker.ADD if marker.points else Marker.DELETE
    return MarkerArray(markers=out)
