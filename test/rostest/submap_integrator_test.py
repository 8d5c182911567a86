#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The submap integrator node makes submaps and obstacles of handovers and poses, and refuses bad input."""

import os
import sys
import tempfile
import time
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import Pose
from mrs_msgs.srv import String
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import Marker, MarkerArray

from node_testing import wait_for
import voxnav
from voxnav.msg import (FinishedSubmap, GridUpdate, Handover, NodeDiagnostics, Progress, SceneChange, SceneChanges,
                        SubmapPoses)
from voxnav.srv import GetGrid, GetSubmaps

TIMEOUT_S = 30.0
VOXEL = 0.4


class Received:
    """Collects the messages of one topic."""

    def __init__(self, topic, kind):
        self.messages = []
        self.subscriber = rospy.Subscriber(topic, kind, self.messages.append, queue_size=100)

    def wait_for(self, condition):
        end = time.time() + TIMEOUT_S
        while time.time() < end:
            for message in list(self.messages):
                if condition(message):
                    return message
            time.sleep(0.02)
        return None

    def wait_for_scene(self, condition):
        end = time.time() + TIMEOUT_S
        while time.time() < end:
            scene = Scene(list(self.messages))
            if condition(scene):
                return scene
            time.sleep(0.05)
        return None


def content(box=True, left=0):
    """Returns the content of a map of the ground with or without a box; its first `left` columns are unknown."""
    states = np.ones((40, 40, 16), np.int8)
    states[:, :, 0] = 2
    if box:
        states[15:20, 15:20, 1:6] = 2
    states[:left] = 0
    return voxnav.map_content_from_array(states, (-8.0, -8.0, 0.0), VOXEL)


def pose(x=0.0, y=0.0, z=0.0):
    out = Pose()
    out.position.x, out.position.y, out.position.z = x, y, z
    out.orientation.w = 1.0
    return out


def handover(submap_id, data, is_final=True, stamp=10.0):
    msg = Handover()
    msg.header.frame_id = "uav1/odom"
    msg.header.stamp = rospy.Time.from_sec(stamp)
    msg.submap_id = submap_id
    msg.is_final = is_final
    msg.start = rospy.Time.from_sec(stamp - 10.0)
    msg.T_O_S = pose(1.0, 2.0, 3.0)
    msg.pose_stamps = [msg.start]
    msg.T_S_B = [pose(0.0, 0.0, 2.0)]
    msg.content = data
    return msg


class Scene:
    """The markers that rviz shows after all messages."""

    def __init__(self, messages):
        self.markers = {}
        for message in messages:
            for marker in getattr(message, "markers", [message]):
                if marker.action == Marker.DELETEALL:
                    self.markers.clear()
                elif marker.action == Marker.DELETE:
                    self.markers.pop((marker.ns, marker.id), None)
                else:
                    self.markers[marker.ns, marker.id] = marker

    @property
    def points(self):
        return np.array([(p.x, p.y, p.z) for m in self.markers.values() for p in m.points]).reshape(-1, 3)

    @property
    def colors(self):
        return {(round(c.r, 3), round(c.g, 3), round(c.b, 3)) for m in self.markers.values() for c in m.colors}


def grid_of(msg):
    grid = voxnav.StateGrid(msg.resolution_m)
    grid.apply_update(msg.block_indices, msg.states, msg.removed_block_indices, True)
    return grid


class SubmapIntegratorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        node = "submap_integrator/"
        cls.submaps = Received(node + "submap_out", FinishedSubmap)
        cls.obstacles = Received(node + "obstacles_out", GridUpdate)
        cls.markers = Received(node + "occupancy_markers_out", MarkerArray)
        cls.cloud = Received(node + "obstacle_cloud_out", PointCloud2)
        cls.mesh = Received(node + "mesh_out", Marker)
        cls.changes = Received(node + "changes_out", SceneChanges)
        cls.slice = Received(node + "slice_out", PointCloud2)
        cls.progress = Received("progress", Progress)
        cls.diagnostics = Received(node + "diagnostics_out", NodeDiagnostics)
        cls.handover = rospy.Publisher(node + "handover_in", Handover, queue_size=10)
        cls.poses = rospy.Publisher(node + "submap_poses_in", SubmapPoses, queue_size=10)
        for service in ("get_obstacles_in", "get_submaps_in", "save_in", "load_in", "merge_in", "export_in"):
            rospy.wait_for_service(node + service, TIMEOUT_S)
        cls.get_obstacles = rospy.ServiceProxy(node + "get_obstacles_in", GetGrid)
        cls.get_submaps = rospy.ServiceProxy(node + "get_submaps_in", GetSubmaps)
        cls.save = rospy.ServiceProxy(node + "save_in", String)
        cls.load = rospy.ServiceProxy(node + "load_in", String)
        cls.merge = rospy.ServiceProxy(node + "merge_in", String)
        cls.export = rospy.ServiceProxy(node + "export_in", String)
        end = time.time() + TIMEOUT_S
        received = [x for x in vars(cls).values() if isinstance(x, Received)]
        while time.time() < end and not (
            cls.handover.get_num_connections()
            and cls.poses.get_num_connections()
            and all(x.subscriber.get_num_connections() for x in received)
        ):
            time.sleep(0.05)

    def test_1_a_handover_becomes_a_submap_and_obstacles(self):
        self.handover.publish(handover(1, content(left=20).to_bytes(), is_final=False))
        self.handover.publish(handover(1, content().to_bytes()))
        msg = self.submaps.wait_for(lambda m: m.submap_id == 1)
        self.assertIsNotNone(msg)
        self.assertEqual(msg.header.frame_id, "uav1/odom")
        self.assertEqual(len(msg.T_S_B), 1)
        submap = voxnav.Submap.from_bytes(msg.data)
        self.assertEqual(len(submap.occupied_points()), content().num_occupied)
        np.testing.assert_allclose(submap.T_S_G[:3, 3], (-1, -2, -3), atol=1e-9)
        self.assertIsNotNone(self.obstacles.wait_for(lambda m: not m.is_snapshot and len(m.block_indices) > 0))
        grid = grid_of(self.get_obstacles().grid)
        points = np.array([[0.2, 0.2, 3.4], [5.0, 5.0, 5.0], [0.0, 0.0, -8.0]], np.float32)
        np.testing.assert_array_equal(grid.states(points), (2, 1, 0))
        self.assertIsNotNone(self.progress.wait_for(lambda m: m.stamp == rospy.Time.from_sec(10.0)))

    def test_2_the_map_is_published_for_rviz(self):
        expected = content().num_occupied
        scene = self.markers.wait_for_scene(lambda s: len(s.points) == expected)
        self.assertIsNotNone(scene)
        self.assertGreater(len(scene.markers), 1)
        self.assertGreater(len(scene.colors), 3)  # colours depend on the height
        self.assertIsNotNone(self.cloud.wait_for(lambda m: m.width > 1000))
        self.assertIsNotNone(self.mesh.wait_for_scene(lambda s: len(s.points) > 1000))
        self.assertIsNotNone(self.slice.wait_for(lambda m: m.width > 500))
        self.assertTrue(all(len(x.points) <= 1200 for m in self.markers.messages for x in m.markers))

    def test_2b_late_subscribers_receive_the_whole_map(self):
        node, expected = "submap_integrator/", content().num_occupied
        # Subscribers of one process share a connection per topic, so only one that closes it first counts as late.
        for old in (self.markers, self.mesh, self.cloud, self.slice):
            old.subscriber.unregister()
        markers = self.__class__.markers = Received(node + "occupancy_markers_out", MarkerArray)
        submaps = Received(node + "submap_markers_out", MarkerArray)
        mesh = self.__class__.mesh = Received(node + "mesh_out", Marker)
        cloud = self.__class__.cloud = Received(node + "obstacle_cloud_out", PointCloud2)
        late_slice = self.__class__.slice = Received(node + "slice_out", PointCloud2)
        self.assertIsNotNone(markers.wait_for_scene(lambda s: len(s.points) == expected))
        scene = submaps.wait_for_scene(lambda s: len(s.points) == expected)
        self.assertIsNotNone(scene)
        self.assertEqual(len(scene.colors), 1)
        self.assertIsNotNone(mesh.wait_for_scene(lambda s: len(s.points) > 1000))
        self.assertIsNotNone(cloud.wait_for(lambda m: m.width > 1000))
        self.assertIsNotNone(late_slice.wait_for(lambda m: m.width > 500))

    def test_3_poses_of_the_optimiser_move_the_obstacles(self):
        msg = SubmapPoses()
        msg.header.frame_id = "uav1/map"
        msg.revision = 7
        msg.submap_ids = [1, 99]
        msg.T_W_S = [pose(101.0, 2.0, 3.0), pose()]
        msg.T_W_O = pose(100.0)
        self.poses.publish(msg)
        self.assertIsNotNone(self.obstacles.wait_for(lambda m: len(m.removed_block_indices) > 0))
        response = self.get_obstacles().grid
        self.assertEqual(response.header.frame_id, "uav1/map")
        points = np.array([[100.2, 0.2, 3.4], [0.2, 0.2, 3.4]], np.float32)
        np.testing.assert_array_equal(grid_of(response).states(points), (2, 0))
        expected = content().num_occupied
        scene = self.markers.wait_for_scene(lambda s: len(s.points) == expected and s.points[:, 0].min() > 90.0)
        self.assertIsNotNone(scene)

    def test_4_newer_free_space_removes_the_box_and_the_correction_holds(self):
        self.handover.publish(handover(2, content(box=False).to_bytes(), stamp=20.0))
        self.assertIsNotNone(self.submaps.wait_for(lambda m: m.submap_id == 2))
        self.assertIsNotNone(self.progress.wait_for(lambda m: m.stamp == rospy.Time.from_sec(20.0)))
        grid = grid_of(self.get_obstacles().grid)
        points = np.array([[99.0, -1.0, 3.0], [99.0, -1.0, 0.6]], np.float32)
        np.testing.assert_array_equal(grid.states(points), (1, 2))

        changes = self.changes.wait_for(lambda m: len(m.changes) == 1)
        self.assertIsNotNone(changes)
        self.assertEqual(changes.changes[0].kind, SceneChange.DISAPPEARED)
        self.assertEqual(changes.changes[0].submap_id, 2)
        self.assertAlmostEqual(changes.changes[0].center.x, 99.0, delta=0.5)
        scene = self.markers.wait_for_scene(lambda s: len(s.points) > 0 and s.points[:, 2].max() < 0.6)
        self.assertIsNotNone(scene)

    def test_4b_bends_are_taken_and_lists_of_wrong_length_refused(self):
        msg = SubmapPoses()
        msg.header.frame_id = "uav1/map"
        msg.submap_ids = [1, 2]
        msg.T_W_S = [pose(101.0, 2.0, 3.0), pose(101.0, 2.0, 3.0)]
        msg.T_W_O = pose(100.0)
        msg.T_S_begin = [pose(), pose()]
        msg.T_S_end = [pose(), pose()]
        self.poses.publish(msg)
        msg.T_S_end = [pose()]
        self.poses.publish(msg)
        self.assertIsNotNone(self.diagnostics.wait_for(
            lambda m: m.level == NodeDiagnostics.ERROR and "T_S_begin and T_S_end" in m.message))

    def test_5_broken_input_is_refused_with_a_reason(self):
        data = content().to_bytes()
        self.handover.publish(handover(3, data[: len(data) // 2], stamp=30.0))
        wrong = handover(3, data, stamp=30.0)
        wrong.T_O_S.orientation.w = float("nan")
        self.handover.publish(wrong)
        lengths = SubmapPoses()
        lengths.submap_ids = [1]
        self.poses.publish(lengths)
        self.assertIsNotNone(
            self.diagnostics.wait_for(lambda m: m.level == NodeDiagnostics.ERROR and "refused" in m.message))
        self.assertEqual(len(self.get_submaps().submaps), 2)

    def test_6_snapshots_come_by_themselves(self):
        snapshot = self.obstacles.wait_for(lambda m: m.is_snapshot and len(m.block_indices) > 0)
        self.assertIsNotNone(snapshot)

    def test_7_saved_and_loaded(self):
        directory = os.path.join(tempfile.mkdtemp(), "map")
        before = self.get_obstacles().grid
        self.assertTrue(self.save(directory).success)
        self.handover.publish(handover(3, content().to_bytes(), stamp=40.0))
        self.assertIsNotNone(self.progress.wait_for(lambda m: m.stamp == rospy.Time.from_sec(40.0)))
        self.assertNotEqual(self.get_obstacles().grid.states, before.states)
        response = self.load(directory)
        self.assertTrue(response.success, response.message)
        self.assertTrue(wait_for(lambda: self.get_obstacles().grid.states == before.states, TIMEOUT_S))
        self.assertEqual(len(self.get_submaps().submaps), 2)
        refused = self.load(directory + "_absent")
        self.assertFalse(refused.success)
        self.assertIn("cannot be read", refused.message)

    def test_8_damaged_submaps_of_a_saved_map_are_left_out_and_the_rest_is_used(self):
        directory = os.path.join(tempfile.mkdtemp(), "map")
        self.assertTrue(self.save(directory).success)
        index = os.path.join(directory, "index.vxi")
        with open(index, "rb") as source:
            data = source.read()
        with open(index, "wb") as out:
            out.write(data[:-40])
        response = self.load(directory)
        self.assertTrue(response.success, response.message)
        self.assertIn("1 of 2 submaps are intact", response.message)
        self.assertEqual([m.submap_id for m in self.get_submaps().submaps], [1])
        self.handover.publish(handover(1, content().to_bytes(), stamp=15.0))
        self.assertIsNotNone(self.submaps.wait_for(lambda m: m.submap_id == 3 and m.header.stamp.to_sec() == 15.0))
        self.assertEqual([m.submap_id for m in self.get_submaps().submaps], [1, 3])

    def test_9_another_flight_is_merged_and_exported(self):
        directory = tempfile.mkdtemp()
        self.assertTrue(self.save(os.path.join(directory, "other")).success)
        before = len(self.get_submaps().submaps)
        response = self.merge(os.path.join(directory, "other") + " 300 0 0 0.5")
        self.assertTrue(response.success, response.message)
        self.assertEqual(len(self.get_submaps().submaps), 2 * before)
        scene = self.markers.wait_for_scene(lambda s: len(s.points) > 0 and s.points[:, 0].max() > 295.0)
        self.assertIsNotNone(scene)
        self.assertFalse(self.merge(os.path.join(directory, "other") + " 1 2").success)
        self.assertTrue(self.export(os.path.join(directory, "files")).success)
        for name in ("mesh.ply", "occupied.ply", "map.ot", "poses.txt"):
            self.assertGreater(os.path.getsize(os.path.join(directory, "files", name)), 10)


if __name__ == "__main__":
    rospy.init_node("submap_integrator_test")
    rostest.rosrun("voxnav", "submap_integrator", SubmapIntegratorTest, sys.argv)
