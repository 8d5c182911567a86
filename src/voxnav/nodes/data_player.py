# SPDX-License-Identifier: BSD-3-Clause
"""Plays a recording to the nodes as fast as they can take it: the clock waits for their progress."""

import threading
import time

import rospy
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu as ImuMsg
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
import tf2_ros
from geometry_msgs.msg import TransformStamped

import numpy as np

from voxnav import files
from voxnav.msg import Progress
from voxnav.nodes.clouds import points_to_msg
from voxnav.offline.datasets import Imu


class PlayerError(RuntimeError):
    """The nodes do not answer; the text says which."""


def _set_pose(position, orientation, T):
    position.x, position.y, position.z = T[:3, 3]
    orientation.x, orientation.y, orientation.z, orientation.w = files.quaternion_from_rotation(T[:3, :3])


class DataPlayer:
    """Publishes clouds, IMU and (when the recording has them) poses of a dataset below the UAV's namespace.

    wait_for: names of the nodes whose Progress each cloud waits for.
    """

    def __init__(self, dataset, origin_frame, body_frame, sensor_frame, wait_for, timeout_s=30.0):
        self._dataset, self._wait_for, self._timeout_s = dataset, tuple(wait_for), timeout_s
        self._origin_frame, self._body_frame, self._sensor_frame = origin_frame, body_frame, sensor_frame
        self._progress = {}
        self._changed = threading.Condition()
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._cloud = rospy.Publisher("os_cloud_nodelet/points", PointCloud2, queue_size=2)
        self._imu = rospy.Publisher("os_cloud_nodelet/imu", ImuMsg, queue_size=500)
        self._odometry = rospy.Publisher("estimation_manager/odom_main", Odometry, queue_size=10)
        self._tf = tf2_ros.TransformBroadcaster()
        rospy.Subscriber("progress", Progress, self._on_progress, queue_size=200)

    def _on_progress(self, msg):
        with self._changed:
            self._progress[msg.node] = max(msg.stamp.to_sec(), self._progress.get(msg.node, 0.0))
            self._changed.notify_all()

    def wait_for_subscribers(self, timeout_s=60.0):
        deadline = time.monotonic() + timeout_s
        while self._cloud.get_num_connections() == 0:
            if time.monotonic() > deadline:
                raise PlayerError("nobody subscribed to the clouds within %.0f s" % timeout_s)
            time.sleep(0.05)

    def play(self, on_scan=None):
        """Play everything; on_scan(count) is called after each scan. Raises PlayerError when a node stops answering."""
        self.wait_for_subscribers()
        for count, record in enumerate(self._scans(), 1):
            self._play_scan(record)
            if on_scan:
                on_scan(count)

    def _scans(self):
        for record in self._dataset:
            if isinstance(record, Imu):
                self._imu.publish(self._imu_msg(record))
            else:
                yield record

    def _imu_msg(self, record):
        out = ImuMsg(header=Header(stamp=rospy.Time.from_sec(record.stamp), frame_id=self._sensor_frame))
        out.angular_velocity.x, out.angular_velocity.y, out.angular_velocity.z = record.gyro
        out.linear_acceleration.x, out.linear_acceleration.y, out.linear_acceleration.z = record.accel
        return out

    def _play_scan(self, scan):
        stamp = rospy.Time.from_sec(scan.stamp)
        if scan.pose is not None:
            self._publish_pose(stamp, scan.pose)
        if scan.raw is not None:
            cloud = PointCloud2()
            cloud.deserialize(_bytes_of(scan.raw))
            cloud.header.frame_id = self._sensor_frame
        else:
            points = scan.points.reshape(-1, 4)
            cloud = points_to_msg(points, Header(stamp=stamp, frame_id=self._sensor_frame))
        self._clock.publish(Clock(clock=stamp + rospy.Duration(0.1)))
        self._cloud.publish(cloud)
        self._await(scan.stamp)

    def _publish_pose(self, stamp, T_O_B):
        odometry = Odometry(header=Header(stamp=stamp, frame_id=self._origin_frame), child_frame_id=self._body_frame)
        _set_pose(odometry.pose.pose.position, odometry.pose.pose.orientation, T_O_B)
        self._odometry.publish(odometry)
        # The tree is inverted: the origin is a child of the body.
        transform = TransformStamped(header=Header(stamp=stamp, frame_id=self._body_frame),
                                     child_frame_id=self._origin_frame)
        _set_pose(transform.transform.translation, transform.transform.rotation, np.linalg.inv(T_O_B))
        self._tf.sendTransform(transform)

    def _await(self, stamp):
        deadline = time.monotonic() + self._timeout_s
        with self._changed:
            while True:
                late = [n for n in self._wait_for if self._progress.get(n, -1.0) < stamp - 1e-6]
                if not late:
                    return
                left = deadline - time.monotonic()
                if left <= 0 or rospy.is_shutdown():
                    raise PlayerError("%s did not deal with the cloud of %.3f within %.0f s" % (
                        ", ".join(late), stamp, self._timeout_s))
                self._changed.wait(left)


def _bytes_of(msg):
    """Wire bytes of a message, so that a class made from a bag's own definition becomes the installed one."""
    import io

    buffer = io.BytesIO()
    msg.serialize(buffer)
    return buffer.getvalue()
