# SPDX-License-Identifier: BSD-3-Clause
"""The demonstration's mission: take off, cross the world, arrive at the goal."""

import os
import time
import xmlrpc.client

import rospy

from voxnav.nodes.flight_recorder import FlightRecorder, MissionError

NODES_LIMIT_S = 120.0
TAKE_OFF_LIMIT_S = 60.0
FLIGHT_LIMIT_S = 420.0


def wait_for_master(uri, timeout_s):
    """Raises MissionError."""
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        try:
            xmlrpc.client.ServerProxy(uri).getPid("/demo")
            return
        except (OSError, xmlrpc.client.Error):
            time.sleep(0.1)
    raise MissionError("no ROS master at %s" % uri)


def fly(record, goal, map_dir, uav="uav1"):
    """Fly to goal (3,), given in the map frame, on the master of the environment.

    Whatever stops the mission ends up in record.reason; the map goes to the folder map_dir.
    """
    recorder = None
    try:
        wait_for_master(os.environ["ROS_MASTER_URI"], 30.0)
        rospy.init_node("demo", disable_signals=True)
        recorder = FlightRecorder(record)
        recorder.wait_for_nodes(NODES_LIMIT_S)
        recorder.take_off(TAKE_OFF_LIMIT_S)
        recorder.fly_to(uav + "/voxnav_map", goal, FLIGHT_LIMIT_S)
        recorder.optimise(10.0)
    except (MissionError, rospy.ROSException, rospy.ServiceException) as error:
        record.reason = str(error)
    if recorder is not None:
        recorder.save_map(map_dir)
        recorder.finish()
