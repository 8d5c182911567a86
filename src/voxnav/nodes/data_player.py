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


SWEEP_S = 0.1  # of the usual sensors


class PlayerError(RuntimeError):
    """The nodes do not answer; the text says which."""


def _set_pose(position, orientation, T):
    position.x, position.y, position.z = T[:3, 3]
    orientation.x, orientation.y, orientation.z, orientation.w = files.quaternion_from_rotation(T[:3, :3])


class DataPlayer:
    """Publishes clouds, IMU and (when the recording has them) poses of a dataset below the UAV's namespace.

    wait_for: node -> number of clouds it may lag behind; each cloud waits for their Progress.
    first_stamp_s: when the recording begins in played time (zero means "newest" to tf, so it cannot be that).
    """

    def __init__(self, dataset, origin_frame, body_frame, sensor_frame, wait_for, T_B_L=None, first_stamp_s=10.0,
                 timeout_s=30.0):
        self._dataset, self._wait_for, self._timeout_s = dataset, dict(wait_for), timeout_s
        self._origin_frame, self._body_frame, self._sensor_frame = origin_frame, body_frame, sensor_frame
        self._T_L_B = np.eye(4) if T_B_L is None else np.linalg.inv(T_B_L)
        self._first_stamp_s, self.offset_s = first_stamp_s, None
        self._stamps = []
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
            if msg.is_begun:
                return
            self._progress[msg.node] = max(msg.stamp.to_sec(), self._progress.get(msg.node, 0.0))
            self._changed.notify_all()

    def wait_for_subscribers(self, timeout_s=60.0):
        deadline = time.monotonic() + timeout_s
        while self._cloud.get_num_connections() == 0:
            if time.monotonic() > deadline:
                raise PlayerError("nobody subscribed to the clouds within %.0f s" % timeout_s)
            time.sleep(0.05)

    def play(self):
        """Play everything, yielding the number of scans played. Raises PlayerError when a node stops answering."""
        self.wait_for_subscribers()
        for count, record in enumerate(self._scans(), 1):
            self._play_scan(record)
            yield count

    def keep_time(self):
        """Lets the clock go on after the last scan, until the node ends, so that tf and rviz go on too."""
        threading.Thread(target=self._tick, daemon=True).start()

    def _tick(self):
        now = rospy.Time.now()
        while not rospy.is_shutdown():
            now += rospy.Duration(0.1)
            self._clock.publish(Clock(clock=now))
            time.sleep(0.1)

    def _scans(self):
        for record in self._dataset:
            if self.offset_s is None:
                self.offset_s = self._first_stamp_s - record.stamp
            if isinstance(record, Imu):
                self._imu.publish(self._imu_msg(record))
            else:
                yield record

    def _imu_msg(self, record):
        out = ImuMsg(header=Header(stamp=self._time(record.stamp), frame_id=self._sensor_frame))
        out.angular_velocity.x, out.angular_velocity.y, out.angular_velocity.z = record.gyro
        out.linear_acceleration.x, out.linear_acceleration.y, out.linear_acceleration.z = record.accel
        return out

    def _time(self, stamp_s):
        return rospy.Time.from_sec(stamp_s + self.offset_s)

    def _play_scan(self, scan):
        stamp = self._time(scan.stamp)
        self._clock.publish(Clock(clock=stamp + rospy.Duration(SWEEP_S)))
        self._publish_poses(scan)
        if scan.raw is not None:
            cloud = PointCloud2()
            cloud.deserialize(_bytes_of(scan.raw))
            cloud.header.frame_id, cloud.header.stamp = self._sensor_frame, stamp
        else:
            points = scan.points.reshape(-1, 4)
            cloud = points_to_msg(points, Header(stamp=stamp, frame_id=self._sensor_frame))
        self._cloud.publish(cloud)
        self._stamps.append(stamp.to_sec())
        self._await()

    def _publish_poses(self, scan):
        """Of the whole sweep where the recording has them: points are moved to one instant by them."""
        if scan.pose is None:
            return
        for after_s in np.linspace(0.0, SWEEP_S, 4) if scan.pose_at else (0.0,):
            T_O_L = scan.pose_at(after_s) if scan.pose_at else scan.pose
            if T_O_L is not None:
                self._publish_pose(self._time(scan.stamp + after_s), T_O_L @ self._T_L_B)

    def _publish_pose(self, stamp, T_O_B):
        odometry = Odometry(header=Header(stamp=stamp, frame_id=self._origin_frame), child_frame_id=self._body_frame)
        _set_pose(odometry.pose.pose.position, odometry.pose.pose.orientation, T_O_B)
        self._odometry.publish(odometry)
        # The tree is inverted: the origin is a child of the body.
        transform = TransformStamped(header=Header(stamp=stamp, frame_id=self._body_frame),
                                     child_frame_id=self._origin_frame)
        _set_pose(transform.transform.translation, transform.transform.rotation, np.linalg.inv(T_O_B))
        self._tf.sendTransform(transform)

    def _await(self):
        wanted = {node: self._stamps[-1 - lag] for node, lag in self._wait_for.items() if len(self._stamps) > lag}
        deadline = time.monotonic() + self._timeout_s
        with self._changed:
            while True:
                late = [node for node, stamp in wanted.items() if self._progress.get(node, -1.0) < stamp - 1e-6]
                if not late:
                    del self._stamps[:-10]
                    return
                left = deadline - time.monotonic()
                if left <= 0 or rospy.is_shutdown():
                    raise PlayerError("%s did not deal with the cloud of %.3f within %.0f s" % (
                        ", ".join(late), self._stamps[-1], self._timeout_s))
                self._changed.wait(left)


def _bytes_of(msg):
    """Wire bytes of a message, so that a class made from a bag's own definition becomes the installed one."""
    import io

    buffer = io.BytesIO()
    msg.serialize(buffer)
    return buffer.getvalue()
