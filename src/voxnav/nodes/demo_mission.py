# SPDX-License-Identifier: BSD-3-Clause
"""Flies the mission of the demonstration: take off, cross the world, arrive at the goal."""

import os
import time
import xmlrpc.client

import rospy

from voxnav.nodes.flight_recorder import FlightRecorder, MissionError
from voxnav.nodes.time_leader import TimeLeader

NODES_LIMIT_S = 120.0
TAKE_OFF_LIMIT_S = 60.0
FLIGHT_LIMIT_S = 420.0
# Limits are wall time; a simulation that waits for its nodes may be that much slower than real time.
WAITING_SLOWNESS = 10.0


def wait_for_master(uri, timeout_s):
    """Waits until the master knows whether time is simulated: a node asks once, when it starts. Raises MissionError."""
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        try:
            if xmlrpc.client.ServerProxy(uri).hasParam("/demo", "/use_sim_time")[2]:
                return
        except (OSError, xmlrpc.client.Error):
            pass
        time.sleep(0.1)
    raise MissionError("no ROS master with the parameter use_sim_time at %s" % uri)


def fly(record, goal, map_dir, uav="uav1", is_leader=False, limit_s=None):
    """Flies to goal (3,), given in the map frame, on the master of the environment.

    limit_s: simulated seconds after which the goal is given up, or None.
    is_leader: the simulator waits for this mission (its leader is "demo") and for the nodes.
    Whatever stops the mission ends up in record.reason; the map goes to the folder map_dir.
    """
    recorder = leader = None
    try:
        wait_for_master(os.environ["ROS_MASTER_URI"], 30.0)
        rospy.init_node("demo", disable_signals=True)
        leader = TimeLeader("demo") if is_leader else None
        recorder = FlightRecorder(record, leader=leader)
        recorder.wait_for_nodes(NODES_LIMIT_S)
        recorder.take_off(TAKE_OFF_LIMIT_S)
        recorder.fly_to(uav + "/voxnav_map", goal, FLIGHT_LIMIT_S * (WAITING_SLOWNESS if is_leader else 1.0),
                        limit_s)
        recorder.optimise(10.0)
    except (MissionError, rospy.ROSException, rospy.ServiceException) as error:
        record.reason = str(error)
    if leader is not None:
        leader.release()
    if recorder is not None:
        recorder.save_map(map_dir)
        recorder.finish()
