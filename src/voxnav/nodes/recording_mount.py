# SPDX-License-Identifier: BSD-3-Clause
"""Publishes the mount of the LiDAR of a recording, beside the player of that recording."""

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from std_msgs.msg import Header

import voxnav
from voxnav.nodes.poses import transform_to_msg
from voxnav.recordings.bag_files import BagFiles, frame_name
from voxnav.recordings.errors import DatasetError
from voxnav.recordings.plan import BagOptions, RecordingPlan


def missing_link(plan, body_frame):
    """Returns the link (parent, child, T_parent_child) that is missing between body_frame and the frame of the clouds.

    It is None if the recording has a chain between them. Raises DatasetError if the mount is not known.
    """
    if plan.error is not None:
        raise DatasetError(plan.error)
    cloud, frames = plan.cloud.frame, plan.survey.frames
    if body_frame == cloud or frames.chain(body_frame, cloud) is not None:
        return None
    root = frames.root(cloud)
    if frames.moving_parents(root):
        raise DatasetError("'%s' has a parent already, '%s': give the recording's own body as body_frame:=%s" % (
            root, frames.moving_parents(root)[0], plan.mount.body))
    below = frames.chain(root, cloud)
    T_root_L = np.eye(4) if below is None else below.T_A_B
    return body_frame, root, plan.mount.T_B_L @ np.linalg.inv(T_root_L)


def main():
    """Runs the node and returns its exit status.

    Parameters: ~bags, paths separated by blanks; ~body_frame; ~uses_lidar_odometry.
    """
    rospy.init_node("recording_mount")
    source = voxnav.PoseSource.LIDAR if rospy.get_param("~uses_lidar_odometry", True) else voxnav.PoseSource.AUTO
    try:
        files = BagFiles(str(rospy.get_param("~bags")).split())
        try:
            link = missing_link(RecordingPlan(files, BagOptions(pose_source=source)),
                                frame_name(rospy.get_param("~body_frame")))
        finally:
            files.close()
    except (DatasetError, OSError) as error:
        rospy.logfatal("%s (with this launch file: sensor_mount:='X Y Z YAW PITCH ROLL')", error)
        return 1
    if link is not None:
        parent, child, T = link
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        broadcaster.sendTransform(TransformStamped(Header(frame_id=parent), child, transform_to_msg(T)))
        rospy.loginfo("'%s' sits on '%s' as the recording says", child, parent)
    rospy.spin()
    return 0
