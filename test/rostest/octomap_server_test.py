#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The services and topics of mrs_octomap_server and mrs_bumper, called as a user of MRS does."""

import glob
import os
import sys
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import TransformStamped
from mrs_msgs.msg import ControlManagerDiagnostics, Float64Stamped, ObstacleSectors
from mrs_msgs.srv import String
from nav_msgs.msg import Odometry
from octomap_msgs.msg import Octomap
from sensor_msgs.msg import LaserScan, PointCloud2
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage

from node_testing import cloud_message, wait_for
import voxnav
from voxnav.msg import FinishedSubmap, Progress

POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("t", "<u4")])
O, W, B = "uav1/world_origin", "uav1/voxnav_map", "uav1/fcu"
HEIGHT_M = 2.0  # of the vehicle above the ground


def scene():
    """Returns points on a wall 5.1 m ahead of the sensor, and on the ground below it."""
    y, z = np.meshgrid(np.arange(-2.0, 2.0, 0.05), np.arange(-1.0, 1.0, 0.05))
    gx, gy = np.meshgrid(np.arange(-2.0, 2.0, 0.1), np.arange(-2.0, 2.0, 0.1))
    points = np.zeros(y.size + gx.size, POINT)
    points["x"] = np.concatenate([np.full(y.size, 5.1), gx.ravel()])
    points["y"] = np.concatenate([y.ravel(), gy.ravel()])
    points["z"] = np.concatenate([z.ravel(), np.full(gx.size, -HEIGHT_M)])
    return points


def transform(parent, child, stamp, z=0.0):
    out = TransformStamped()
    out.header.stamp, out.header.frame_id, out.child_frame_id = stamp, parent, child
    out.transform.translation.z, out.transform.rotation.w = z, 1.0
    return out


class OctomapServerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = rospy.get_param("octomap_server/node/map_path")
        for path in glob.glob(os.path.join(cls.folder, "*")):
            os.remove(path)
        cls.received = {}
        topics = [("octomap_server/octomap_%s_%s" % (part, form), Octomap) for part in ("local", "global")
                  for form in ("full", "binary")]
        topics += [("bumper/obstacle_sectors", ObstacleSectors), ("laser_scan_cloud/cloud", PointCloud2),
                   ("submap_integrator/submap", FinishedSubmap), ("progress", Progress)]
        cls.subscribers = [rospy.Subscriber(name, kind, cls.received.setdefault(name, []).append, queue_size=50)
                           for name, kind in topics]
        cls.cloud = rospy.Publisher("local_mapper/points_in", PointCloud2, queue_size=10)
        cls.odometry = rospy.Publisher("estimation_manager/odom_main", Odometry, queue_size=10)
        cls.control = rospy.Publisher("control_manager/diagnostics", ControlManagerDiagnostics, queue_size=10)
        cls.height = rospy.Publisher("estimation_manager/height_agl", Float64Stamped, queue_size=10)
        cls.scan = rospy.Publisher("rplidar/scan", LaserScan, queue_size=10)
        cls.tf = rospy.Publisher("/tf", TFMessage, queue_size=100)
        cls.is_flying, cls.body_z, cls.has_height = False, 0.0, False
        cls.has_cloud = True
        wait_for(lambda: cls.cloud.get_num_connections() and cls.tf.get_num_connections() >= 2)
        cls.timer = rospy.Timer(rospy.Duration(0.1), cls.tick)
        for name in ("save_map", "load_map", "reset_map"):
            rospy.wait_for_service("octomap_server/" + name, 30.0)
        cls.save = rospy.ServiceProxy("octomap_server/save_map", String)
        cls.load = rospy.ServiceProxy("octomap_server/load_map", String)
        cls.reset = rospy.ServiceProxy("octomap_server/reset_map", Empty)

    @classmethod
    def tick(cls, _):
        """Publishes what a vehicle at rest does, and one scan."""
        now = rospy.Time.now()
        cls.tf.publish(TFMessage([transform(O, B, now, cls.body_z), transform(B, "uav1/os_sensor", now),
                                  transform(O, W, now)]))
        cls.control.publish(ControlManagerDiagnostics(stamp=now, flying_normally=cls.is_flying,
                                                      output_enabled=cls.is_flying))
        if cls.has_height:
            height = Float64Stamped(value=HEIGHT_M)
            cls.height.publish(height)
        odometry = Odometry(child_frame_id=B)
        odometry.header.stamp, odometry.header.frame_id = now, O
        odometry.pose.pose.orientation.w, odometry.pose.pose.position.z = 1.0, cls.body_z
        cls.odometry.publish(odometry)
        if not cls.has_cloud:
            return
        cls.cloud.publish(cloud_message(scene(), (now - rospy.Duration(0.05)).to_sec()))

    def newest(self, topic, condition=lambda msg: True):
        """Waits for a message that comes from now on."""
        messages = self.received[topic]
        begin = len(messages)
        self.assertTrue(wait_for(lambda: any(condition(m) for m in messages[begin:])), "nothing on %s" % topic)
        return next(m for m in reversed(messages) if condition(m))

    def submap(self):
        """Waits for a submap that begins from now on, so that the global map knows the scene."""
        self.newest("submap_integrator/submap")
        self.newest("submap_integrator/submap")

    def expect(self, response, *texts):
        for text in texts:
            self.assertIn(text, response.message)
        return response

    def test_1_maps_come_as_octomaps(self):
        self.submap()
        for part, frame in (("local", O), ("global", W)):
            for form in ("full", "binary"):
                msg = self.newest("octomap_server/octomap_%s_%s" % (part, form), lambda m: len(m.data) > 100)
                self.assertEqual((msg.id, msg.binary, msg.header.frame_id), ("OcTree", form == "binary", frame))
                self.assertAlmostEqual(msg.resolution, 0.4)
                self.assertLess(abs((rospy.Time.now() - msg.header.stamp).to_sec()), 2.0)

    def test_2_a_map_is_saved_forgotten_and_loaded(self):
        self.submap()
        self.assertTrue(self.expect(self.save("forest"), "forest.ot").success)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "forest.ot")))
        self.assertTrue(self.save("forest").success)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "forest_backup.ot")))
        self.timer.shutdown()  # without scans nothing comes into the map again
        self.reset()
        type(self).has_cloud, type(self).timer = False, rospy.Timer(rospy.Duration(0.1), self.tick)
        try:
            self.check_loading()
        finally:
            type(self).has_cloud, type(self).is_flying, type(self).has_height = True, False, False

    def check_loading(self):
        """Loads a map in which the ground lies HEIGHT_M below the body, on the ground and in the air."""
        newest = "octomap_server/octomap_global_full"
        self.newest(newest, lambda m: len(m.data) == 0)
        # The vehicle stands: the ground of the map must rise to 0.3 m below its body.
        response = self.load("forest")
        self.assertTrue(self.expect(response, "submaps loaded, raised by").success)
        self.assertAlmostEqual(float(response.message.split()[-2]), HEIGHT_M - 0.3, delta=0.3)
        self.newest(newest, lambda m: len(m.data) > 100)
        type(self).is_flying = True
        self.assertTrue(wait_for(lambda: "in the air without a measured height" in self.load("forest").message))
        type(self).has_height = True
        self.assertTrue(wait_for(lambda: self.load("forest").success))
        self.assertAlmostEqual(float(self.load("forest").message.split()[-2]), 0.0, delta=0.3)

    def test_3_bad_names_and_files_are_refused_with_a_reason(self):
        for name in ("../forest", "/etc/passwd", "a/b", "", ".hidden", "a b", "..", "x" * 200):
            for service in (self.save, self.load):
                self.assertFalse(self.expect(service(name), "is no name of a map").success, name)
        self.assertFalse(self.expect(self.load("nowhere"), "no map 'nowhere'", "forest").success)
        with open(os.path.join(self.folder, "broken.ot"), "wb") as out:
            out.write(b"# Octomap OcTree file\nid OcTree\nsize 9\nres 0.4\ndata\n123")
        self.assertFalse(self.expect(self.load("broken"), "broken.ot", "in the middle of its nodes").success)
        fine = voxnav.LocalMap(voxnav.LocalMapConfig(resolution_m=0.2, window_size_m=(30.0, 30.0, 10.0)))
        for _ in range(4):
            points = scene()
            fine.insert(np.stack([points["x"], points["y"], points["z"]], axis=1), np.eye(4))
        fine.save_octomap(os.path.join(self.folder, "fine.ot"))
        self.assertFalse(self.expect(self.load("fine"), "voxels of 0.2", "voxels of 0.4").success)
        os.symlink("/etc/hostname", os.path.join(self.folder, "link.ot"))
        self.assertFalse(self.expect(self.load("link"), "is a link").success)
        self.assertFalse(os.path.exists(os.path.join(os.path.dirname(self.folder), "forest.ot")))

    def test_4_the_map_is_saved_in_flight_with_a_backup(self):
        path = os.path.join(self.folder, "autosaved.ot")
        for saved in glob.glob(os.path.join(self.folder, "autosaved*")):
            os.remove(saved)  # the vehicle flew in an earlier test
        type(self).is_flying = True
        self.assertTrue(wait_for(lambda: os.path.exists(path[:-3] + "_backup.ot")))
        type(self).is_flying = False
        self.assertTrue(os.path.exists(path))

    def test_5_the_bumper_tells_what_is_near_and_never_falls_silent(self):
        self.submap()
        msg = self.newest("bumper/obstacle_sectors", lambda m: m.sectors[0] > 0.0)
        self.assertEqual((len(msg.sectors), len(msg.sector_sensors), msg.n_horizontal_sectors), (10, 10, 8))
        self.assertEqual(msg.header.frame_id, "uav1/fcu_untilted")
        self.assertAlmostEqual(msg.sectors[0], 5.0, delta=0.4)
        self.assertAlmostEqual(msg.sectors[8], HEIGHT_M, delta=0.4)
        self.assertEqual(msg.sector_sensors[0], ObstacleSectors.SENSOR_LIDAR3D)
        self.timer.shutdown()
        try:
            none = ObstacleSectors.OBSTACLE_NO_DATA
            self.newest("bumper/obstacle_sectors", lambda m: set(m.sectors) == {none})
            self.newest("bumper/obstacle_sectors")
        finally:
            type(self).timer = rospy.Timer(rospy.Duration(0.1), self.tick)
        self.newest("bumper/obstacle_sectors", lambda m: m.sectors[0] > 0.0)

    def test_6_scans_of_a_2d_scanner_become_clouds(self):
        scan = LaserScan(angle_min=-1.0, angle_increment=0.5, range_min=0.1, range_max=10.0,
                         ranges=[2.0, float("inf"), 3.0, 0.01, 50.0])
        scan.header.frame_id = "uav1/rplidar"
        wait_for(self.scan.get_num_connections)
        self.scan.publish(scan)
        self.assertTrue(wait_for(lambda: self.received["laser_scan_cloud/cloud"]))
        cloud = self.received["laser_scan_cloud/cloud"][-1]
        points = np.frombuffer(cloud.data, "<f4").reshape(-1, 3)
        np.testing.assert_array_equal(np.isnan(points[:, 0]), [False, True, False, True, True])
        np.testing.assert_allclose(points[0], [2.0 * np.cos(-1.0), 2.0 * np.sin(-1.0), 0.0], rtol=1e-6)
        self.assertEqual(cloud.header.frame_id, "uav1/rplidar")


if __name__ == "__main__":
    rospy.init_node("octomap_server_test")
    rostest.rosrun("voxnav", "octomap_server", OctomapServerTest, sys.argv)
