#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The chain of PCL filters in the node, and a program of pcl_ros that reads what the node publishes."""

import glob
import os
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np
import rospy
import rostest
from sensor_msgs.msg import PointCloud2, PointField

import voxnav
from voxnav.msg import NodeDiagnostics, Progress

TIMEOUT_S = 20.0
FIELDS = ("x", "y", "z", "intensity")
PROGRAMS_OF_PCL_ROS = "/opt/ros/noetic/lib/pcl_ros:/usr/lib/pcl_ros"


def wait_for(condition):
    end = time.time() + TIMEOUT_S
    while not condition() and time.time() < end:
        time.sleep(0.02)
    return condition()


def dome():
    """(32, 256, 4) float32: a shell of 9 m whose rows 8 to 15 met nothing."""
    elevation = np.linspace(0.9, -0.7, 32)[:, None]
    azimuth = -2.0 * np.pi * np.arange(256)[None, :] / 256
    points = np.zeros((32, 256, 4), np.float32)
    points[..., 0] = 9.0 * np.cos(elevation) * np.cos(azimuth)
    points[..., 1] = 9.0 * np.cos(elevation) * np.sin(azimuth)
    points[..., 2], points[..., 3] = 9.0 * np.sin(elevation), 100.0
    points[8:16] = 0.0
    return points


def to_msg(points, stamp_s):
    msg = PointCloud2(height=points.shape[0], width=points.shape[1], point_step=16, row_step=16 * points.shape[1])
    msg.header.stamp, msg.header.frame_id = rospy.Time.from_sec(stamp_s), "uav1/os_sensor"
    msg.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate(FIELDS)]
    msg.data = points.tobytes()
    return msg


def read_pcd(path):
    """(names, rows) of an ASCII file of PCL."""
    header, rows = {}, []
    with open(path) as source:
        for line in source:
            key, *rest = line.split()
            if header.get("DATA"):
                rows.append([float(value) for value in line.split()])
            elif key != "#":
                header[key] = rest
    return header["FIELDS"], np.array(rows)


class PclFiltersTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.points, cls.diagnostics, cls.progress = [], [], []
        subscribers = [rospy.Subscriber("cloud_filter/points_out", PointCloud2, cls.points.append),
                       rospy.Subscriber("cloud_filter/diagnostics_out", NodeDiagnostics, cls.diagnostics.append),
                       rospy.Subscriber("progress", Progress, cls.progress.append)]
        cls.cloud = rospy.Publisher("cloud_filter/cloud_in", PointCloud2, queue_size=10)
        wait_for(lambda: cls.cloud.get_num_connections() and all(s.get_num_connections() for s in subscribers))
        config = voxnav.PclFiltersConfig(filters=["crop_box", "voxel_grid"], crop_box_min=[-20, -20, 0.5],
                                         crop_box_max=[20, 20, 20], leaf_size=0.5)
        cls.filters = voxnav.make_pcl_filters(config)
        cls.filter, cls.beams = voxnav.CloudFilter(), voxnav.OpenBeams(voxnav.OpenBeamsConfig(is_enabled=True))

    def send(self, stamp_s):
        had = len(self.points)
        self.cloud.publish(to_msg(dome(), stamp_s))
        self.assertTrue(wait_for(lambda: len(self.points) > had), "no output")
        return self.points[-1]

    def expected(self):
        """(points (n, 4), directions (k, 3)) by the same parts without ROS."""
        msg = to_msg(dome(), 0.0)
        layout = voxnav.CloudLayout(msg.height, msg.width, msg.point_step,
                                    [(f.name, f.offset, f.datatype, f.count) for f in msg.fields])
        result = self.filter.apply(dome())
        for pcl_filter in self.filters:
            pcl_filter.apply(result)
        return result.points, self.beams.find(msg.data, layout)

    def test_the_chain_filters_points_and_leaves_open_beams_alone(self):
        for i in range(8):  # where a beam points is learnt from its returns
            out = self.send(10.0 + 0.1 * i)
            points, beams = self.expected()
        rows = np.frombuffer(out.data, np.float32).reshape(-1, out.point_step // 4)
        is_beam = np.isnan(rows[:, 0])
        np.testing.assert_array_equal(rows[~is_beam, :4], points)
        np.testing.assert_array_equal(rows[is_beam, 5:], beams)
        self.assertGreater(len(beams), 50)
        self.assertGreater(points[:, 2].min(), 0.5)
        self.assertLess(len(points), 16 * 256)

        def stages():
            return {s.name for d in self.diagnostics for s in d.stages}
        self.assertTrue(wait_for(lambda: {"filter", "pcl crop_box", "pcl voxel_grid"} <= stages()), stages())
        counters = dict(zip(self.diagnostics[-1].counter_names, self.diagnostics[-1].counter_values))
        self.assertGreater(counters["points_pcl"], 0)

    def test_pcl_ros_reads_what_is_published(self):
        program = shutil.which("pointcloud_to_pcd", path=PROGRAMS_OF_PCL_ROS)
        self.assertTrue(program, "pointcloud_to_pcd of pcl_ros is not installed")
        folder = tempfile.mkdtemp()
        topic = rospy.resolve_name("cloud_filter/points_out")
        writer = subprocess.Popen([program, "input:=" + topic, "_prefix:=" + folder + "/"])
        try:
            stamp = [30.0]

            def is_written():
                stamp[0] += 0.1
                self.send(stamp[0])
                return len(glob.glob(folder + "/*.pcd")) >= 2  # the first is then complete
            self.assertTrue(wait_for(is_written), "no file")
        finally:
            writer.terminate()
            writer.wait()
        path = sorted(glob.glob(folder + "/*.pcd"))[0]
        names, rows = read_pcd(path)
        out = [m for m in self.points if os.path.basename(path).startswith(str(m.header.stamp.to_nsec() // 1000))]
        shutil.rmtree(folder)
        self.assertEqual(names[:5], ["x", "y", "z", "intensity", "t"])
        self.assertEqual(len(out), 1)
        published = np.frombuffer(out[0].data, np.float32).reshape(-1, out[0].point_step // 4)
        np.testing.assert_allclose(rows[:, :4], published[:, :4], rtol=1e-5)


if __name__ == "__main__":
    rospy.init_node("pcl_filters_test")
    rostest.rosrun("voxnav", "pcl_filters", PclFiltersTest, sys.argv)
