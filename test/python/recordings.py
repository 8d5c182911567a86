# SPDX-License-Identifier: BSD-3-Clause
"""Small recordings of a simulated flight, for tests that map them: sweeps of a LiDAR, and rosbags with them."""

import os
from typing import Callable, NamedTuple

import numpy as np

from voxnav import files, simulation

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SPEED_MPS, YAW_RATE_RADPS, SWEEP_S = 2.0, 0.3, 0.1
MOUNT = simulation.pose(0.1, 0.0, 0.15)
FIRST_STAMP_S, NUM_SCANS = 1.0, 16


def body_pose(t):
    """Returns the pose T_O_B (4, 4) of the flight at t seconds."""
    return simulation.pose(SPEED_MPS * t, 0.0, 2.0, YAW_RATE_RADPS * t)


def sweeps(T_B_L=MOUNT, num_scans=NUM_SCANS):
    """Returns the world, and scans of it by a sensor that moves while it turns."""
    world = simulation.World(os.path.join(ROOT, "worlds", "grove.yaml"), seed=2)
    lidar = simulation.Lidar(model="os0-32", columns=256, dropout_ratio=0.0)
    return world, [lidar.scan(world, body_pose(t) @ T_B_L, body_pose(t + SWEEP_S) @ T_B_L, scan_index=i)
                   for i, t in enumerate(FIRST_STAMP_S + SWEEP_S * np.arange(num_scans))]


POINT_FIELD_TYPES = {"<i4": 5, "<u4": 6, "<f4": 7, "<f8": 8}


class TimeField(NamedTuple):
    """The point times that a driver writes.

    written: computes them from the offsets (w,) of the columns and the start of the sweep, both in seconds.
    stamp_s: the stamp of the cloud, in seconds after the start of its sweep.
    """

    name: str = "t"
    dtype: str = "<u4"
    written: Callable = lambda offsets_s, start_s: np.round(offsets_s * 1e9)
    stamp_s: float = 0.0


ABSOLUTE_TIMES = TimeField("timestamp", "<f8", lambda offsets_s, start_s: offsets_s + start_s)


def cloud_message(scan, start, times=TimeField()):
    """Returns a scan whose sweep began at `start` seconds as PointCloud2 with point times."""
    import rospy
    from sensor_msgs.msg import PointCloud2, PointField

    height, width = scan.ranges_m.shape
    rows = np.zeros((height, width), dtype=[("xyzi", "<f4", 4), ("t", times.dtype)])
    rows["xyzi"] = scan.organised
    written = np.asarray(times.written(scan.column_times_s.astype(np.float64), start))
    rows["t"] = (written % 2**32 if times.dtype == "<u4" else written).astype(times.dtype)[None, :]
    step = rows.dtype.itemsize
    msg = PointCloud2(height=height, width=width, point_step=step, row_step=step * width, data=rows.tobytes())
    msg.fields = [PointField(n, 4 * i, 7, 1) for i, n in enumerate(("x", "y", "z", "intensity"))]
    if times.name:
        msg.fields.append(PointField(times.name, 16, POINT_FIELD_TYPES[times.dtype], 1))
    msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(start + times.stamp_s), "lidar"
    return msg


def set_pose(pose, T):
    position = pose.position if hasattr(pose, "position") else pose.translation
    orientation = pose.orientation if hasattr(pose, "orientation") else pose.rotation
    position.x, position.y, position.z = T[:3, 3]
    orientation.x, orientation.y, orientation.z, orientation.w = files.quaternion_from_rotation(T[:3, :3])


def imu_message(stamp):
    """Returns an IMU message of the body, which turns evenly about the vertical and flies without acceleration."""
    import rospy
    from sensor_msgs.msg import Imu

    msg = Imu()
    msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(stamp), "body"
    msg.angular_velocity.z = YAW_RATE_RADPS
    msg.linear_acceleration.z = 9.81
    return msg


def odometry_message(stamp, T_O_B, child="body"):
    import rospy
    from nav_msgs.msg import Odometry

    msg = Odometry(child_frame_id=child)
    msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(stamp), "odom"
    set_pose(msg.pose.pose, T_O_B)
    return msg


def link(parent, child, T_parent_child, stamp=0.0):
    """Returns a message for /tf or /tf_static with one transform."""
    import rospy
    from geometry_msgs.msg import TransformStamped
    from tf2_msgs.msg import TFMessage

    transform = TransformStamped(child_frame_id=child)
    transform.header.stamp, transform.header.frame_id = rospy.Time.from_sec(stamp), parent
    set_pose(transform.transform, T_parent_child)
    return TFMessage([transform])


def flight(scans, T_B_L=MOUNT, with_odometry=True, with_imu=False, first_stamp_s=FIRST_STAMP_S,
           times=TimeField()):
    """Returns messages as [record time in s, topic, message].

    The scans are on /points, their mount on /tf_static, odometry at 50 Hz on /odom and the IMU at 200 Hz on /imu.
    first_stamp_s: the stamp of the first scan, which shows the flight at FIRST_STAMP_S.
    """
    out = [[first_stamp_s - 0.1, "/tf_static", link("body", "lidar", T_B_L)]]
    later_s = first_stamp_s - FIRST_STAMP_S
    end_s = 1.2 + SWEEP_S * len(scans)
    for t in np.arange(0.9, end_s, 0.02) if with_odometry else ():
        out.append([t + later_s, "/odom", odometry_message(t + later_s, body_pose(t))])
    for t in np.arange(0.9, end_s, 0.005) if with_imu else ():
        out.append([t + later_s, "/imu", imu_message(t + later_s)])
    for i, scan in enumerate(scans):
        stamp = first_stamp_s + SWEEP_S * i
        out.append([stamp + SWEEP_S, "/points", cloud_message(scan, stamp, times)])
    return out


def of_topic(messages, topic):
    """Returns the messages of one topic, which callers change in place."""
    return [message for message in messages if message[1] == topic]


def write_messages(path, messages, compression="none", is_sorted=True):
    """Writes a bag with messages as flight() returns them; is_sorted: whether to sort them by record time first."""
    import rosbag
    import rospy

    with rosbag.Bag(path, "w", compression, chunk_threshold=100000) as out:
        for record_s, topic, msg in sorted(messages, key=lambda message: message[0]) if is_sorted else messages:
            out.write(topic, msg, rospy.Time.from_sec(record_s))
    return path


def write_bag(path, scans, *args, **kwargs):
    """Writes a bag with the messages of flight(scans, ...)."""
    write_messages(path, flight(scans, *args, **kwargs))
