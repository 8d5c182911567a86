# SPDX-License-Identifier: BSD-3-Clause
"""Publishes the messages that Livox drivers make by default as clouds, for a cloud filter.

The bytes of a message are read as they are, by the definition that livox_ros_driver and livox_ros_driver2 share, so
that neither has to be installed: their points become the points of the cloud without being touched.
"""

import struct

import rospy
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from voxnav.msg import NodeDiagnostics
from voxnav.nodes.node_base import Diagnostics, run_node

TYPES = ("livox_ros_driver/CustomMsg", "livox_ros_driver2/CustomMsg")
POINT_STEP = 19
# Of livox_ros_driver/CustomPoint: nanoseconds after the first point, metres, reflectivity, tag and number of the laser.
FIELDS = [PointField("offset_time", 0, PointField.UINT32, 1), PointField("x", 4, PointField.FLOAT32, 1),
          PointField("y", 8, PointField.FLOAT32, 1), PointField("z", 12, PointField.FLOAT32, 1),
          PointField("reflectivity", 16, PointField.UINT8, 1), PointField("tag", 17, PointField.UINT8, 1),
          PointField("line", 18, PointField.UINT8, 1)]


def cloud_of(data):
    """Returns the PointCloud2 of a serialised CustomMsg. Raises ValueError saying why the bytes are none."""
    try:
        sequence, seconds, nanoseconds, length = struct.unpack_from("<IIII", data, 0)
        frame = bytes(data[16:16 + length]).decode("utf-8")
        # timebase, point_num, lidar_id, rsvd, and the length of the list of points
        _, _, _, count = struct.unpack_from("<QI4sI", data, 16 + length)
    except (struct.error, UnicodeDecodeError) as error:
        raise ValueError("its %d bytes are no livox_ros_driver/CustomMsg: %s" % (len(data), error))
    begin = 16 + length + struct.calcsize("<QI4sI")
    if len(data) - begin != POINT_STEP * count:
        raise ValueError("it has %d bytes for %d points, but should have %d: another version of the driver?" % (
            len(data) - begin, count, POINT_STEP * count))
    header = Header(sequence, rospy.Time(seconds, nanoseconds), frame)
    return PointCloud2(header=header, height=1, width=count, fields=FIELDS, point_step=POINT_STEP,
                       row_step=POINT_STEP * count, data=bytes(data[begin:]), is_dense=True)


class LivoxCloud:
    """The node."""

    def __init__(self):
        self.diagnostics = Diagnostics(rospy.get_name().split("/")[-1])
        self.num_refused = 0
        self._clouds = rospy.Publisher("~cloud_out", PointCloud2, queue_size=5)
        self._subscriber = rospy.Subscriber("~livox_in", rospy.AnyMsg, self._on_message, queue_size=5,
                                            buff_size=1 << 24, tcp_nodelay=True)

    def _on_message(self, msg):
        kind = msg._connection_header["type"]
        try:
            if kind not in TYPES:
                raise ValueError("it is a %s, which is none of %s" % (kind, " and ".join(TYPES)))
            with self.diagnostics.time("convert"):
                self._clouds.publish(cloud_of(msg._buff))
            self.diagnostics.set_level(NodeDiagnostics.OK)
        except ValueError as error:
            self.num_refused += 1
            self.diagnostics.set_counter("messages_refused", self.num_refused)
            self.diagnostics.set_level(NodeDiagnostics.ERROR, "message on %s refused: %s" % (
                self._subscriber.resolved_name, error))
            rospy.logerr_throttle(5.0, "message on %s refused: %s", self._subscriber.resolved_name, error)


def main():
    run_node("livox_cloud", LivoxCloud)
