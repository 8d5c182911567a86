# SPDX-License-Identifier: BSD-3-Clause
"""Turns the depth images of a recording into clouds, by the code of the nodelet DepthCloud."""

from __future__ import annotations

from typing import Any

import voxnav
from voxnav.recordings.bag_files import BagFiles

IMAGE, CAMERA_INFO = "sensor_msgs/Image", "sensor_msgs/CameraInfo"


def info_topic_of(image_topic: str) -> str:
    """Returns the topic of the camera_info of a camera, which by custom of ROS lies beside its images."""
    return "/".join(image_topic.split("/")[:-1] + ["camera_info"])


class DepthImages:
    """Makes clouds of the images on one topic. Not thread-safe. config: DepthCloudConfig."""

    def __init__(self, image_topic: str, config: Any) -> None:
        self.info_topic = info_topic_of(image_topic)
        self._depth_cloud = voxnav.DepthCloud(config)
        self._model: Any = None
        self._problem = "nothing came on %s" % self.info_topic

    def add_info(self, msg: Any) -> None:
        """Takes a sensor_msgs/CameraInfo. One that is of no use leaves the one before. Raises ValueError."""
        try:
            self._model = voxnav.camera_of(msg)
        except ValueError as error:
            self._problem = str(error)
            raise

    def take_first_info(self, files: BagFiles) -> None:
        """Takes the first camera_info of a recording that is of use, for images that were recorded before it."""
        for message in files.messages([self.info_topic]):
            try:
                self.add_info(message.make())
                return
            except ValueError:
                continue

    def cloud(self, image: Any) -> Any:
        """Returns a sensor_msgs/Image as sensor_msgs/PointCloud2, organised and in the optical frame.

        Raises ValueError saying why the image cannot be used.
        """
        from sensor_msgs.msg import PointCloud2, PointField

        if self._model is None:
            raise ValueError("there is no camera for it: " + self._problem)
        data, layout = self._depth_cloud.convert_message(image, self._model)
        return PointCloud2(header=image.header, height=layout.height, width=layout.width, data=data,
                           fields=[PointField(*field) for field in layout.fields], point_step=layout.point_step,
                           row_step=layout.point_step * layout.width)
