# SPDX-License-Identifier: BSD-3-Clause
"""Small recordings of a simulated flight, for tests that map them: sweeps of a LiDAR, and a rosbag of them."""

import os

import numpy as np

from voxnav import files, simulation

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SPEED_MPS, YAW_RATE_RADPS, SWEEP_S = 2.0, 0.3, 0.1
MOUNT = simulation.pose(0.1, 0.0, 0.15)
FIRST_STAMP_S, NUM_SCANS = 1.0, 16


def body_pose(t):
    """T_O_B of the flight, (4, 4), at t seconds."""
    return simulation.pose(SPEED_MPS * t, 0.0, 2.0, YAW_RATE_RADPS * t)


def sweeps(T_B_L=MOUNT, num_scans=NUM_SCANS):
    """The world, and organised scans (h, w, 4) with column times (w,) of a sensor that moves while it turns."""
    world = simulation.World(os.path.join(ROOT, "worlds", "grove.yaml"), seed=2)
    lidar = simulation.Lidar(model="os0-32", columns=256, dropout_ratio=0.0)
    return world, [lidar.scan(world, body_pose(t) @ T_B_L, body_pose(t + SWEEP_S) @ T_B_L, scan_index=i)
                   for i, t in enumerate(FIRST_STAMP_S + SWEEP_S * np.arange(num_scans))]


def cloud_message(scan, stamp):
    import rospy
    from sensor_msgs.msg import PointCloud2, PointField

    height, width = scan.ranges_m.shape
    rows = np.zeros((height, width), dtype=[("xyzi", "<f4", 4), ("t", "<u4")])
    rows["xyzi"] = scan.organised
    rows["t"] = np.round(scan.column_times_s * 1e9).astype(np.uint32)[None, :]
    msg = PointCloud2(height=height, width=width, point_step=20, row_step=20 * width, data=rows.tobytes())
    msg.fields = [PointField(n, 4 * i, 7, 1) for i, n in enumerate(("x", "y", "z", "intensity"))]
    msg.fields.append(PointField("t", 16, 6, 1))
    msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(stamp), "lidar"
    return msg


def set_pose(pose, T):
    position = pose.position if hasattr(pose, "position") else pose.translation
    orientation = pose.orientation if hasattr(pose, "orientation") else pose.rotation
    position.x, position.y, position.z = T[:3, 3]
    orientation.x, orientation.y, orientation.z, orientation.w = files.quaternion_from_rotation(T[:3, :3])


def imu_message(stamp):
    """Of the body, which turns evenly around the vertical and flies along a straight line without acceleration."""
    import rospy
    from sensor_msgs.msg import Imu

    msg = Imu()
    msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(stamp), "body"
    msg.angular_velocity.z = YAW_RATE_RADPS
    msg.linear_acceleration.z = 9.81
    return msg


def write_bag(path, scans, T_B_L=MOUNT, with_odometry=True, with_imu=False, first_stamp_s=FIRST_STAMP_S):
    """A bag with the scans on /points, their mount on /tf_static, odometry at 50 Hz on /odom, IMU at 200 Hz on /imu.

    first_stamp_s: of the first scan, which shows the flight at FIRST_STAMP_S.
    """
    import rosbag
    import rospy
    from geometry_msgs.msg import TransformStamped
    from nav_msgs.msg import Odometry
    from tf2_msgs.msg import TFMessage

    with rosbag.Bag(path, "w", chunk_threshold=100000) as out:
        mount = TransformStamped(child_frame_id="lidar")
        mount.header.frame_id = "body"
        set_pose(mount.transform, T_B_L)
        out.write("/tf_static", TFMessage([mount]), rospy.Time.from_sec(first_stamp_s - 0.1))
        later_s = first_stamp_s - FIRST_STAMP_S
        end_s = 1.2 + SWEEP_S * len(scans)
        for t in np.arange(0.9, end_s, 0.02) if with_odometry else ():
            odometry = Odometry(child_frame_id="body")
            odometry.header.stamp, odometry.header.frame_id = rospy.Time.from_sec(t + later_s), "odom"
            set_pose(odometry.pose.pose, body_pose(t))
            out.write("/odom", odometry, rospy.Time.from_sec(t + later_s))
        for t in np.arange(0.9, end_s, 0.005) if with_imu else ():
            out.write("/imu", imu_message(t + later_s), rospy.Time.from_sec(t + later_s))
        for i, scan in enumerate(scans):
            stamp = first_stamp_s + SWEEP_S * i
            out.write("/points", cloud_message(scan, stamp), rospy.Time.from_sec(stamp + SWEEP_S))
