# SPDX-License-Identifier: BSD-3-Clause
"""Plays a recording to the nodes as fast as they can take it: the clock waits for their progress."""

import threading
import time

import rosgraph
import rospy
from nav_msgs.msg import Odometry as OdometryMsg
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu as ImuMsg
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
import tf2_ros
from geometry_msgs.msg import Pose, TransformStamped

import numpy as np

from voxnav.msg import Progress
import voxnav
from voxnav.nodes.clouds import points_to_msg, shift_time
from voxnav.nodes.poses import pose_from_msg, pose_to_msg, transform_to_msg
from voxnav.offline.datasets import Imu, Odometry


SWEEP_S = 0.1  # the duration of a sweep of common sensors
LAST_SCAN_LIMIT_S = 10.0  # the limit of the wait for the last scan, whose poses may be missing


class PlayerError(RuntimeError):
    """Nodes do not answer; the text names them."""


class DataPlayer:
    """Publishes clouds, IMU and, if the recording has them, poses of a dataset below the UAV's namespace.

    wait_for: {node: number of clouds it may lag behind}; each cloud waits for their Progress.
    wait_once_located: as wait_for, for nodes that need poses. No cloud waits for them before is_located() tells that
    poses come: LiDAR odometry publishes none before it knows where up is.
    first_stamp_s: a recording that begins earlier is moved to begin at this time, because tf takes a zero stamp for
    "newest"; other recordings keep their stamps.
    """

    def __init__(self, dataset, origin_frame, body_frame, sensor_frame, wait_for, wait_once_located, is_located,
                 T_B_L=None, first_stamp_s=10.0, timeout_s=30.0):
        self._dataset, self._timeout_s = dataset, timeout_s
        self._wait_for, self._wait_once_located, self._is_located = wait_for, wait_once_located, is_located
        self._origin_frame, self._body_frame, self._sensor_frame = origin_frame, body_frame, sensor_frame
        self._T_L_B = np.eye(4) if T_B_L is None else np.linalg.inv(T_B_L)
        self._first_stamp_ns, self._offset_ns = int(1e9 * first_stamp_s), None
        self._stamps = []
        self._times = voxnav.PointTimes()
        self._progress = {}
        self._changed = threading.Condition()
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._cloud = rospy.Publisher("os_cloud_nodelet/points", PointCloud2, queue_size=2)
        # Nodes wait for an IMU that somebody offers, and so would the player for the nodes.
        self._imu = rospy.Publisher("os_cloud_nodelet/imu", ImuMsg, queue_size=500) if dataset.has_imu else None
        self._odometry = rospy.Publisher("estimation_manager/odom_main", OdometryMsg, queue_size=500)
        self._tf = tf2_ros.TransformBroadcaster()
        rospy.Subscriber("progress", Progress, self._on_progress, queue_size=200)

    def _on_progress(self, msg):
        with self._changed:
            if msg.is_begun:
                return
            self._progress[msg.node] = max(msg.stamp.to_sec(), self._progress.get(msg.node, 0.0))
            self._changed.notify_all()

    def wait_for_subscribers(self, timeout_s=60.0):
        """Waits until all subscribers of the topics are connected, because they would miss earlier messages."""
        deadline = time.monotonic() + timeout_s
        while not self._is_heard():
            if time.monotonic() > deadline:
                raise PlayerError("not everybody got his connection to the clouds within %.0f s" % timeout_s)
            time.sleep(0.05)

    def _is_heard(self):
        subscribers = dict(rosgraph.Master(rospy.get_name()).getSystemState()[1])
        topics = [topic for topic in (self._cloud, self._imu, self._odometry) if topic is not None]
        wanted = {topic.resolved_name: len(subscribers.get(topic.resolved_name, ())) for topic in topics}
        return wanted[self._cloud.resolved_name] > 0 and all(
            topic.get_num_connections() >= wanted[topic.resolved_name] for topic in topics)

    def play(self):
        """Plays the recording, yields the number of scans played, and waits until the nodes have processed it.

        Raises PlayerError if a node stops answering.
        """
        self.wait_for_subscribers()
        for count, record in enumerate(self._scans(), 1):
            self._play_scan(record)
            yield count
        self._wait_for = dict.fromkeys(self._wait_for, 0)
        self._wait_once_located = dict.fromkeys(self._wait_once_located, 0)
        self._timeout_s = LAST_SCAN_LIMIT_S
        try:
            self._await()
        except PlayerError as error:  # the recording may end before the poses of its last scan
            rospy.logwarn("the recording ends within its last scan: %s", error)

    def keep_time(self):
        """Lets the clock run on after the last scan, until the node ends, so that tf and rviz keep working."""
        threading.Thread(target=self._tick, daemon=True).start()

    def _tick(self):
        now = rospy.Time.now()
        while not rospy.is_shutdown():
            now += rospy.Duration(0.1)
            self._clock.publish(Clock(clock=now))
            time.sleep(0.1)

    @property
    def offset_s(self):
        """Returns played time minus recorded time, or None before the first record."""
        return None if self._offset_ns is None else 1e-9 * self._offset_ns

    @property
    def last_stamps_s(self):
        """Returns the stamps of the last scans as they were played, at most ten, oldest first."""
        return list(self._stamps[-10:])

    def _scans(self):
        for record in self._dataset:
            if self._offset_ns is None:
                self._offset_ns = max(0, self._first_stamp_ns - record.stamp_ns)
            if isinstance(record, Imu):
                self._imu.publish(self._imu_msg(record))
            elif isinstance(record, Odometry):
                self._publish_pose(self._time(record.stamp_ns), self._pose_of(record))
            else:
                yield record

    def _imu_msg(self, record):
        out = ImuMsg(header=Header(stamp=self._time(record.stamp_ns), frame_id=self._body_frame))
        out.angular_velocity.x, out.angular_velocity.y, out.angular_velocity.z = record.gyro
        out.linear_acceleration.x, out.linear_acceleration.y, out.linear_acceleration.z = record.accel
        return out

    def _time(self, stamp_ns):
        return rospy.Time(0, stamp_ns + self._offset_ns)

    def _play_scan(self, scan):
        stamp = self._time(scan.stamp_ns)
        self._clock.publish(Clock(clock=stamp + rospy.Duration(SWEEP_S)))
        if scan.T_O_L is not None:
            self._publish_pose(stamp, pose_to_msg(scan.T_O_L @ self._T_L_B))
        if scan.raw is not None:
            cloud = PointCloud2()
            cloud.deserialize(_bytes_of(scan.raw))
            cloud.header.frame_id = self._sensor_frame
            self._move(cloud, stamp)
        else:
            points = scan.points.reshape(-1, 4)
            cloud = points_to_msg(points, Header(stamp=stamp, frame_id=self._sensor_frame))
        self._cloud.publish(cloud)
        self._stamps.append(stamp.to_sec())
        self._await()

    def _move(self, cloud, stamp):
        """Moves a cloud with its point times to the played time. The nodes report clouds that cannot be read."""
        try:
            shift_time(cloud, stamp.to_nsec() - cloud.header.stamp.to_nsec(), self._times)
        except ValueError:
            cloud.header.stamp = stamp

    @staticmethod
    def _pose_of(record):
        """Returns the recorded pose as a message, to the last bit."""
        out = Pose()
        out.position.x, out.position.y, out.position.z = record.position
        out.orientation.x, out.orientation.y, out.orientation.z, out.orientation.w = record.q_xyzw
        return out

    def _publish_pose(self, stamp, pose):
        """Publishes a pose as odometry and as tf, in which the origin is a child of the body, as in the MRS system."""
        odometry = OdometryMsg(header=Header(stamp=stamp, frame_id=self._origin_frame), child_frame_id=self._body_frame)
        odometry.pose.pose = pose
        self._odometry.publish(odometry)
        header = Header(stamp=stamp, frame_id=self._body_frame)
        self._tf.sendTransform(TransformStamped(header=header, child_frame_id=self._origin_frame,
                                                transform=transform_to_msg(np.linalg.inv(pose_from_msg(pose)))))

    def _await(self):
        lags = dict(self._wait_for, **(self._wait_once_located if self._is_located() else {}))
        wanted = {node: self._stamps[-1 - lag] for node, lag in lags.items() if len(self._stamps) > lag}
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
    """Returns the wire bytes of a message, by which a class made from a bag's definition becomes the installed one."""
    import io

    buffer = io.BytesIO()
    msg.serialize(buffer)
    return buffer.getvalue()
