# SPDX-License-Identifier: BSD-3-Clause
"""Plays a recording to the mapping nodes."""

import os

import numpy as np
import rospy
from std_srvs.srv import Trigger

from voxnav.nodes.data_player import DataPlayer, PlayerError
from voxnav.nodes.demo_mission import wait_for_master
from voxnav.nodes.flight_recorder import FlightRecorder, MissionError

MAPPING_NODES = ("cloud_filter", "local_mapper", "submap_integrator", "submap_optimizer")
NODES_LIMIT_S = 120.0
CLOSING_LIMIT_S = 30.0
LAST_SUBMAP_LIMIT_S = 15.0


def run(record, dataset, has_poses, T_B_L, reference, on_scan, map_dir, uav="uav1"):
    """Plays a recording on the master of the environment. Whatever stops it ends up in record.reason.

    The map is saved to map_dir.

    reference: (stamps, positions) on the recording's clock, or None.
    """
    nodes = MAPPING_NODES if has_poses else MAPPING_NODES + ("lidar_odometry",)
    # With times of their own, points wait for IMU samples up to the end of their sweep and for the pose there. Those
    # come with the next cloud, and with LiDAR odometry one cloud later.
    lags = {"cloud_filter": 0} if has_poses else {"cloud_filter": 0, "lidar_odometry": 1}
    mapper_lag = 1 if has_poses else 2
    recorder, player, played = None, None, 0
    try:
        wait_for_master(os.environ["ROS_MASTER_URI"], 30.0)
        rospy.init_node("demo_real", disable_signals=True)
        topic = "estimation_manager/odom_main" if has_poses else "lidar_odometry/odom"
        recorder = FlightRecorder(record, nodes, topic)
        player = DataPlayer(dataset, uav + "/slam_origin", uav + "/fcu", uav + "/os_sensor", lags,
                            {"local_mapper": mapper_lag}, lambda: len(record.odometry[0]) > 0, T_B_L)
        recorder.wait_for_nodes(NODES_LIMIT_S)
        for played in player.play():
            on_scan(played)
        player.keep_time()
        _close(recorder, record, player.last_stamps_s, mapper_lag)
        record.reached = True
    except (MissionError, PlayerError, ValueError, rospy.ROSException, rospy.ServiceException) as error:
        record.reason = "%s, after %d of %d scans" % (error, played, dataset.num_scans)
    else:
        record.reason = "%d of %d scans" % (played, dataset.num_scans)
    if recorder is None:
        return
    if reference is not None and player.offset_s is not None:
        for stamp, position in zip(*reference):
            record.truth_track.add(stamp + player.offset_s, position)
    recorder.save_map(map_dir)
    recorder.finish()
    stamps = record.odometry[0]
    if len(stamps):
        record.mission = (stamps[0], stamps[-1])


def _close(recorder, record, stamps_s, lag):
    """Requests the handover of the open submap, and waits until the map contains it.

    stamps_s: of the last scans played. lag: number of them whose poses come too late, with the recording at its end.
    """
    rospy.wait_for_service("local_mapper/close_submap", 10.0)
    answer = rospy.ServiceProxy("local_mapper/close_submap", Trigger)()
    if not answer.success:
        raise MissionError("the last submap was not closed: " + answer.message)
    # The last scan that can be in the map; half a millisecond covers stamps that are rounded on their way.
    expected_s = stamps_s[-1 - lag] - 5e-4 if len(stamps_s) > lag else -np.inf
    try:
        recorder.wait_until(lambda: _ends_after(record, expected_s), LAST_SUBMAP_LIMIT_S, "the last submap")
    except MissionError:  # the last scans were not mapped, for reasons that the nodes gave
        recorder.wait_until(lambda: _ends_after(record, expected_s - 0.5), CLOSING_LIMIT_S,
                            "the optimised trajectory of the whole recording")
    recorder.optimise(10.0)
    recorder.wait_for_map(10.0)


def _ends_after(record, stamp_s):
    """Returns whether the optimised trajectory reaches to the stamp."""
    return len(record.optimised[0]) > 0 and record.optimised[0][-1] >= stamp_s
