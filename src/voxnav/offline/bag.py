# SPDX-License-Identifier: BSD-3-Clause
"""Rosbags as a stream of records (see ``datasets``)."""

import bisect
import collections
import os
import shutil
import tempfile

import numpy as np

from voxnav import files
from voxnav.offline.datasets import DatasetError, Imu, Scan

_CLOUD, _ODOMETRY, _IMU = "sensor_msgs/PointCloud2", "nav_msgs/Odometry", "sensor_msgs/Imu"


def _open(path, warnings):
    """A readable bag. One without an index (truncated, not closed) is repaired in a temporary copy."""
    import rosbag  # here, so that raw scan folders need no ROS

    if not os.path.exists(path):
        raise DatasetError("%s: no such file" % path)
    try:
        return rosbag.Bag(path), None
    except rosbag.ROSBagUnindexedException:
        pass
    except (rosbag.ROSBagException, OSError) as error:
        raise DatasetError("%s: not a readable bag: %s" % (path, error))
    copy = tempfile.NamedTemporaryFile(suffix=".bag", delete=False)
    copy.close()
    shutil.copyfile(path, copy.name)
    try:
        with rosbag.Bag(copy.name, "a", allow_unindexed=True) as bag:
            for _ in bag.reindex():
                pass
        repaired = rosbag.Bag(copy.name)
    except Exception as error:  # the reader fails in many ways on damaged bytes
        os.unlink(copy.name)
        raise DatasetError("%s: truncated, and nothing in it can be recovered: %s" % (path, error))
    warnings.append("%s was not closed properly (truncated?); mapped what is intact" % path)
    return repaired, copy.name


def _pose(msg):
    T = np.eye(4)
    q, p = msg.orientation, msg.position
    T[:3, :3] = files.rotation_from_quaternion([q.x, q.y, q.z, q.w])
    T[:3, 3] = [p.x, p.y, p.z]
    return T


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


class Bag:
    """Clouds, and odometry and IMU where there are any.

    Topics left empty are found by type; more than one cloud topic needs a choice. Raises DatasetError.
    """

    def __init__(self, path, cloud_topic="", odometry_topic="", imu_topic="", T_B_L=None, use_odometry=True):
        self.warnings = []
        self._bag, self._copy = _open(path, self.warnings)
        self._T_B_L = np.eye(4) if T_B_L is None else T_B_L
        self.cloud_topic = self._topic(_CLOUD, cloud_topic, required=True)
        self.odometry_topic = self._topic(_ODOMETRY, odometry_topic) if use_odometry else ""
        self.imu_topic = self._topic(_IMU, imu_topic)
        self.num_scans = self._bag.get_message_count(topic_filters=[self.cloud_topic])

    def close(self):
        self._bag.close()
        if self._copy:
            os.unlink(self._copy)

    def _topic(self, kind, wanted, required=False):
        topics = self._bag.get_type_and_topic_info().topics
        found = sorted(name for name, info in topics.items() if info.msg_type == kind and info.message_count > 0)
        if wanted:
            if wanted not in found:
                raise DatasetError("no messages of type %s on %s; the bag has %s" % (kind, wanted, found or "none"))
            return wanted
        if not found:
            if required:
                raise DatasetError("the bag has no %s; its topics are %s" % (kind, sorted(topics)))
            return ""
        if len(found) > 1:
            self.warnings.append("several topics of type %s, taking %s of %s" % (kind, found[0], found))
        return found[0]

    def __iter__(self):
        """Scans wait until odometry has passed their stamp, so that their pose is interpolated, not guessed."""
        stamps, poses = [], []
        waiting = collections.deque()
        last_stamp = -np.inf
        topics = [t for t in (self.cloud_topic, self.odometry_topic, self.imu_topic) if t]
        for topic, msg, _ in self._bag.read_messages(topics=topics):
            stamp = msg.header.stamp.to_sec()
            if topic == self.imu_topic:
                w, a = msg.angular_velocity, msg.linear_acceleration
                yield Imu(stamp, np.array([w.x, w.y, w.z]), np.array([a.x, a.y, a.z]))
            elif topic == self.odometry_topic:
                if stamps and stamp <= stamps[-1]:
                    self.warnings.append("odometry time goes back at %.6f; message left out" % stamp)
                    continue
                stamps.append(stamp)
                poses.append(_pose(msg.pose.pose))
                del stamps[:-500], poses[:-500]
                while waiting and waiting[0][0] <= stamp:
                    yield self._scan(*waiting.popleft(), stamps, poses)
            else:
                if stamp <= last_stamp:
                    self.warnings.append("cloud time goes back at %.6f; cloud left out" % stamp)
                    continue
                last_stamp = stamp
                if self.odometry_topic and (not stamps or stamp > stamps[-1]):
                    waiting.append((stamp, msg))
                else:
                    yield self._scan(stamp, msg, stamps, poses)
        for stamp, msg in waiting:
            yield self._scan(stamp, msg, stamps, poses)

    def _scan(self, stamp, msg, stamps, poses):
        T_O_B = interpolate_pose(stamps, poses, stamp) if self.odometry_topic else None
        if self.odometry_topic and T_O_B is None:
            self.warnings.append("no odometry around cloud %.6f" % stamp)
        return Scan(stamp, None, msg, None if T_O_B is None else T_O_B @ self._T_B_L)
