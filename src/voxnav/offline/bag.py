# SPDX-License-Identifier: BSD-3-Clause
"""Rosbags as a stream of records (see ``datasets``)."""

from __future__ import annotations

import os
import shutil
import tempfile
from typing import Any, Iterator

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.offline.datasets import DatasetError, Imu, Odometry, Scan

# Number of messages that are searched for the sensor's mount.
_MAX_STATIC_TRANSFORMS = 1000

_CLOUD, _ODOMETRY, _IMU = "sensor_msgs/PointCloud2", "nav_msgs/Odometry", "sensor_msgs/Imu"


def _open(path: str, warnings: list[str]) -> tuple[Any, str | None]:
    """Opens a bag. One without an index (truncated, not closed) is repaired in a temporary copy."""
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


def _pose(msg: Any) -> Array:
    """Returns the (4, 4) matrix of a Transform."""
    q, p = msg.rotation, msg.translation
    return voxnav.pose_from_quaternion((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


class Bag:
    """Clouds, and odometry and IMU where there are any.

    Topics left empty are found by type; where there are several, the first in the alphabet is taken, with a warning.
    T_B_L: (4, 4) mount of the LiDAR on the body; None takes it from /tf_static, or else the identity, with a warning.
    Raises DatasetError.
    """

    def __init__(self, path: str, cloud_topic: str = "", odometry_topic: str = "", imu_topic: str = "",
                 T_B_L: Array | None = None, use_odometry: bool = True) -> None:
        self.warnings: list[str] = []
        self._bag, self._copy = _open(path, self.warnings)
        self.cloud_topic = self._topic(_CLOUD, cloud_topic, required=True)
        self.odometry_topic = self._topic(_ODOMETRY, odometry_topic) if use_odometry else ""
        self.imu_topic = self._topic(_IMU, imu_topic)
        self.has_poses = bool(self.odometry_topic)
        self.num_scans = self._bag.get_message_count(topic_filters=[self.cloud_topic])
        self.T_B_L = self._mount() if T_B_L is None else T_B_L

    def close(self) -> None:
        self._bag.close()
        if self._copy:
            os.unlink(self._copy)

    def _topic(self, kind: str, wanted: str, required: bool = False) -> str:
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
        return str(found[0])

    def _first(self, topic: str) -> Any:
        return next((msg for _, msg, _ in self._bag.read_messages(topics=[topic])), None)

    def _mount(self) -> Array:
        """Returns T_B_L from the frames that the messages of the cloud and of odometry (or IMU) name."""
        cloud, body = self._first(self.cloud_topic).header.frame_id, ""
        if self.odometry_topic:
            body = self._first(self.odometry_topic).child_frame_id
        elif self.imu_topic:
            body = self._first(self.imu_topic).header.frame_id
        if not body or body == cloud:
            return np.eye(4)
        for count, (_, msg, _) in enumerate(self._bag.read_messages(topics=["/tf_static", "tf_static"])):
            for link in msg.transforms:
                ends = (link.header.frame_id, link.child_frame_id)
                if ends == (body, cloud):
                    return _pose(link.transform)
                if ends == (cloud, body):
                    return np.linalg.inv(_pose(link.transform))
            if count >= _MAX_STATIC_TRANSFORMS:
                break
        self.warnings.append("no transform from %s to %s on /tf_static: the sensor is taken to sit at the body's "
                             "origin; give run/mount_position_m and run/mount_rpy_rad" % (body, cloud))
        return np.eye(4)

    def __iter__(self) -> Iterator[Imu | Odometry | Scan]:
        topics = [t for t in (self.cloud_topic, self.odometry_topic, self.imu_topic) if t]
        for topic, msg, _ in self._bag.read_messages(topics=topics):
            stamp_ns = msg.header.stamp.to_nsec()
            if topic == self.imu_topic:
                w, a = msg.angular_velocity, msg.linear_acceleration
                yield Imu(stamp_ns, np.array([w.x, w.y, w.z]), np.array([a.x, a.y, a.z]))
            elif topic == self.odometry_topic:
                p, q = msg.pose.pose.position, msg.pose.pose.orientation
                yield Odometry(stamp_ns, (p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
            else:
                yield Scan(stamp_ns, None, msg, None)
