# SPDX-License-Identifier: BSD-3-Clause
"""Messages of Livox drivers become clouds that the filter reads, point times included."""

import io
import struct

import numpy as np
import pytest

pytest.importorskip("rospy")

import voxnav  # noqa: E402
from std_msgs.msg import Header  # noqa: E402
from voxnav.nodes.livox_cloud import cloud_of  # noqa: E402
from voxnav.recordings.cloud_samples import layout_of  # noqa: E402

POINT = np.dtype([("offset_time", "<u4"), ("xyz", "<f4", 3), ("reflectivity", "u1"), ("tag", "u1"), ("line", "u1")])
NUM_POINTS = 500


def message(frame="livox_frame", stamp_ns=100 * 10**9 + 7):
    """The bytes of a livox_ros_driver/CustomMsg, written by its definition, and its points."""
    import rospy

    points = np.zeros(NUM_POINTS, POINT)
    points["offset_time"] = np.arange(NUM_POINTS) * 200_000
    points["xyz"] = np.random.default_rng(1).uniform(2.0, 20.0, (NUM_POINTS, 3))
    points["reflectivity"], points["line"] = 40, np.arange(NUM_POINTS) % 6
    out = io.BytesIO()
    Header(3, rospy.Time(0, stamp_ns), frame).serialize(out)
    out.write(struct.pack("<QIB3BI", stamp_ns, NUM_POINTS, 1, 0, 0, 0, NUM_POINTS) + points.tobytes())
    return out.getvalue(), points


def test_points_and_their_times_arrive():
    data, points = message()
    cloud = cloud_of(data)
    assert cloud.header.frame_id == "livox_frame" and cloud.header.stamp.to_nsec() == 100 * 10**9 + 7
    result = voxnav.CloudFilter(voxnav.CloudFilterConfig()).apply_raw(
        cloud.data, layout_of(cloud), stamp_ns=cloud.header.stamp.to_nsec())
    np.testing.assert_array_equal(result.points[:, :3], points["xyz"])
    np.testing.assert_array_equal(result.points[:, 3], 40.0)
    np.testing.assert_array_equal(result.time_offsets_ns, points["offset_time"])


@pytest.mark.parametrize("spoil", [lambda data: data[:10], lambda data: data[:-5], lambda data: data + b"12",
                                   lambda data: b"", lambda data: data[:12] + b"\xff\xff\xff\xff" + data[16:]])
def test_other_bytes_are_refused_with_a_reason(spoil):
    with pytest.raises(ValueError, match="bytes"):
        cloud_of(spoil(message()[0]))
