#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""One local map of a LiDAR, a second LiDAR and a depth camera: each is mapped, and what fails costs itself alone."""

import sys
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from tf2_msgs.msg import TFMessage

from local_mapper_test import POINT, mirror, wall
from node_testing import cloud_message, wait_for
from voxnav.msg import NodeDiagnostics, Progress
from voxnav.srv import GetGrid

WIDTH, HEIGHT, FOCAL = 64, 48, 50.0
# Walls of 5.1 m before each sensor: ahead for the LiDAR, behind for the rear one, and of 3.1 m on the left for the
# camera, which looks there.
MOUNTS = {"uav1/os_sensor": (0.0, 0.0, 0.0, 1.0), "uav1/rear": (0.0, 0.0, 1.0, 0.0),
          "uav1/front": (-0.7071, 0.0, 0.0, 0.7071)}
WALLS = {"lidar": (5.1, 0.0, 0.1), "rear": (-5.1, 0.0, 0.1), "front": (0.0, 3.1, 0.1)}
OCCUPIED = 2
BLOCK_SIDE, RESOLUTION_M = 16, 0.4


def transform(parent, child, stamp_s, rotation=(0.0, 0.0, 0.0, 1.0)):
    out = TransformStamped(child_frame_id=child)
    out.header.stamp, out.header.frame_id = rospy.Time.from_sec(stamp_s), parent
    q = out.transform.rotation
    q.x, q.y, q.z, q.w = rotation
    return out


def depth_image(stamp_s, depth_m=3.1, encoding="16UC1"):
    pixels = np.full((HEIGHT, WIDTH), 1000 * depth_m, np.uint16)
    msg = Image(height=HEIGHT, width=WIDTH, encoding=encoding, step=2 * WIDTH, data=pixels.tobytes())
    msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(stamp_s), "uav1/front"
    return msg


def camera_info(focal=FOCAL):
    return CameraInfo(height=HEIGHT, width=WIDTH,
                      P=[focal, 0, WIDTH / 2 - 0.5, 0, 0, focal, HEIGHT / 2 - 0.5, 0, 0, 0, 1, 0])


def is_occupied(grid, point):
    """Whether the voxel at a point, or one beside it, is occupied in a grid as mirror() gives it."""
    for offset in np.array(np.meshgrid(*[(-1, 0, 1)] * 3)).reshape(3, -1).T:
        voxel = np.floor(np.array(point) / RESOLUTION_M).astype(int) + offset
        states = grid.get(tuple(voxel // BLOCK_SIDE))
        local = voxel % BLOCK_SIDE
        number = local[0] + BLOCK_SIDE * (local[1] + BLOCK_SIDE * local[2])  # four voxels a byte
        if states and states[number // 4] >> 2 * (number % 4) & 3 == OCCUPIED:
            return True
    return False


class SensorsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.progress, cls.diagnostics = [], {"local_mapper": [], "depth_cloud_front": []}
        subscribers = [rospy.Subscriber("progress", Progress, cls.progress.append)]
        subscribers += [rospy.Subscriber(node + "/diagnostics_out", NodeDiagnostics, said.append)
                        for node, said in cls.diagnostics.items()]
        cls.clouds = {"lidar": rospy.Publisher("local_mapper/points_in", PointCloud2, queue_size=10),
                      "rear": rospy.Publisher("local_mapper/rear/points_in", PointCloud2, queue_size=10)}
        cls.image = rospy.Publisher("depth_cloud_front/image_in", Image, queue_size=10)
        cls.info = rospy.Publisher("depth_cloud_front/camera_info_in", CameraInfo, queue_size=10, latch=True)
        cls.tf = rospy.Publisher("/tf", TFMessage, queue_size=100)
        publishers = list(cls.clouds.values()) + [cls.image, cls.info, cls.tf]
        assert wait_for(lambda: all(p.get_num_connections() for p in publishers + subscribers))
        cls.now = 1000.0

    def move_time(self):
        """A tenth of a second passes, in which the body stands still."""
        type(self).now += 0.1
        for stamp_s in (self.now - 0.02, self.now + 0.02):
            links = [transform("uav1/fcu", frame, stamp_s, q) for frame, q in MOUNTS.items()]
            self.tf.publish(TFMessage([transform("uav1/world_origin", "uav1/fcu", stamp_s)] + links))
        return self.now

    def scan(self, sensor, frame=None, points=None, stamp_s=None):
        """One cloud of a LiDAR, which is awaited."""
        msg = cloud_message(wall() if points is None else points, self.move_time() if stamp_s is None else stamp_s)
        msg.header.frame_id = frame or {"lidar": "uav1/os_sensor", "rear": "uav1/rear"}[sensor]
        name = "local_mapper" if sensor == "lidar" else "local_mapper/" + sensor
        done = self.num_done(name)
        self.clouds[sensor].publish(msg)
        self.assertTrue(wait_for(lambda: self.num_done(name) > done), "no progress after a cloud of " + sensor)

    def look(self, **options):
        """One image of the camera, which is awaited."""
        done = self.num_done("local_mapper/front")
        self.image.publish(depth_image(self.move_time(), **options))
        self.assertTrue(wait_for(lambda: self.num_done("local_mapper/front") > done), "no progress after an image")

    def num_done(self, name):
        return sum(progress.node == name for progress in self.progress)

    def counter(self, name, node="local_mapper"):
        said = self.diagnostics[node]
        return dict(zip(said[-1].counter_names, said[-1].counter_values)).get(name) if said else None

    def expect_message(self, text, node="local_mapper"):
        said = self.diagnostics[node]
        self.assertTrue(wait_for(lambda: any(text in d.message for d in said)),
                        "%s never said: %s, but %s" % (node, text, sorted({d.message for d in said})))

    def grid(self):
        return mirror([rospy.ServiceProxy("local_mapper/get_map_in", GetGrid)().grid])

    def test_1_all_of_them_make_one_map(self):
        self.info.publish(camera_info())
        for _ in range(4):
            self.scan("lidar")
            self.scan("rear")
            self.look()
        grid = self.grid()
        for sensor, point in WALLS.items():
            self.assertTrue(is_occupied(grid, point), sensor)
        for sensor in WALLS:
            self.assertTrue(wait_for(lambda: self.counter(sensor + "/scans_mapped") == 4), sensor)

    def test_2_a_second_lidar_that_fails_costs_itself_alone(self):
        mapped, dropped = self.counter("lidar/scans_mapped"), self.counter("rear/scans_dropped")
        for kind in range(3):
            if kind == 0:  # its clouds are broken
                bad = cloud_message(wall(), self.move_time())
                bad.data = bad.data[:-5]
                self.clouds["rear"].publish(bad)
            elif kind == 1:  # its clock stands still
                self.scan("rear")
                self.scan("rear", stamp_s=self.now)
            else:  # nobody knows where it sits: it waits for its pose while the LiDAR is mapped
                lost = cloud_message(wall(), self.move_time())
                lost.header.frame_id = "uav1/nowhere"
                self.clouds["rear"].publish(lost)
            for _ in range(3):
                self.scan("lidar")
                self.look()
        self.expect_message("scan dropped: rear")
        self.expect_message("nowhere")
        self.assertTrue(wait_for(lambda: self.counter("rear/scans_dropped") == dropped + 3))
        self.assertTrue(wait_for(lambda: self.counter("lidar/scans_mapped") == mapped + 9))
        self.assertEqual(self.counter("lidar/scans_dropped"), 0)
        self.assertEqual(self.counter("map_clears"), None)

    def test_3_a_second_lidar_that_died_is_missed_while_the_others_go_on(self):
        moved = wall()
        moved["x"] = 8.1
        mapped = self.counter("lidar/scans_mapped")
        said = self.diagnostics["local_mapper"]
        del said[:]
        num_scans = 0
        while num_scans < 400 and not any("'rear' is silent" in d.message for d in said):
            self.scan("lidar", points=moved)
            self.look()
            num_scans += 1
        self.expect_message("sensor 'rear' is silent: nothing came on /uav1/local_mapper/rear/points_in for")
        self.assertTrue(wait_for(lambda: self.counter("lidar/scans_mapped") == mapped + num_scans))
        self.assertTrue(is_occupied(self.grid(), (8.1, 0.0, 0.1)))
        self.assertTrue(is_occupied(self.grid(), WALLS["rear"]), "what it saw stays")
        self.scan("rear")
        self.assertTrue(wait_for(lambda: self.counter("sensors_silent") == 0))

    def test_4_bad_images_are_counted_and_said(self):
        node = "depth_cloud_front"
        self.image.publish(depth_image(self.move_time(), encoding="bgr8"))
        self.expect_message("its encoding is 'bgr8'", node)
        self.assertTrue(wait_for(lambda: self.counter("images_refused", node) == 1))
        self.info.publish(camera_info(focal=0.0))
        self.expect_message("camera_info tells no intrinsics", node)
        self.assertTrue(wait_for(lambda: self.counter("camera_infos_refused", node) == 1))
        self.look()  # by the camera that is known

    def test_5_an_empty_cloud_is_no_fault(self):
        self.scan("rear", points=np.zeros(0, POINT))


if __name__ == "__main__":
    rospy.init_node("local_mapper_sensors_test")
    rostest.rosrun("voxnav", "local_mapper_sensors", SensorsTest, sys.argv)
