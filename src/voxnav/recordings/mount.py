# SPDX-License-Identifier: BSD-3-Clause
"""Finds the mounts of LiDAR and IMU on the body of the poses. An unknown mount is an error, never the identity."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from voxnav.array_types import Array
from voxnav.recordings.errors import DatasetError, Problem
from voxnav.recordings.survey import Survey, TopicSurvey

_WITHOUT_IMU = "; or leave the IMU out with odometry/use_imu: false"
HOW_TO_SET = ("give it with --mount 'X Y Z ROLL PITCH YAW' (metres and radians; the LiDAR on the body), or as run/"
              "mount_position_m and run/mount_rpy_rad with run/mount_source: given")


class Mount(NamedTuple):
    """The mounts of a recording.

    T_B_L: (4, 4) pose of the LiDAR on the body; R_B_I: (3, 3) rotation of the IMU, None if neither known nor needed;
    body: the frame of the body; how: the source of the mount, for people; notes: assumptions that were made.
    """

    T_B_L: Array
    R_B_I: Array | None
    body: str
    how: str
    notes: list[Problem]


def find_mount(survey: Survey, cloud: TopicSurvey, odometry: TopicSurvey | None, imu: TopicSurvey | None,
               T_B_L: Array | None = None) -> Mount:
    """Returns the mounts on the body, which is that of the odometry, else the IMU, and without both the LiDAR itself.

    T_B_L: (4, 4) mount that the user gives; None takes it from the transforms of the recording. Raises DatasetError.
    """
    notes: list[Problem] = []
    body = _body_frame(survey, cloud, odometry, imu, notes)
    how = "as given"
    if T_B_L is None and odometry is None and imu is None:
        T_B_L, how = np.eye(4), "poses are those of the LiDAR itself"
    elif T_B_L is None:
        T_B_L, how = _lidar_on_body(survey, cloud, body, odometry, imu)
    R_B_I = None
    if imu is not None:
        R_B_I = np.eye(3) if odometry is None else _imu_on_body(survey, cloud, body, imu, T_B_L)
    return Mount(T_B_L, R_B_I, body, how, notes)


def find_further_mount(survey: Survey, cloud: TopicSurvey, other: TopicSurvey, mount: Mount) -> tuple[Array, str]:
    """T_B_L (4, 4) of another sensor, by the transforms between it and the LiDAR, and where it is from, for people.

    Raises DatasetError.
    """
    if other.frame == cloud.frame:
        return mount.T_B_L, "its clouds are in the frame of the LiDAR"
    chain = survey.frames.chain(cloud.frame, other.frame)
    if chain is None:
        survey.see_all_frames()
        chain = survey.frames.chain(cloud.frame, other.frame)
    if chain is None:
        known = survey.frames.frames()
        raise DatasetError(
            "nothing says where the sensor of %s sits: there is no chain of transforms that do not move from '%s' "
            "(frame of the clouds on %s) to '%s'; frames on /tf and /tf_static: %s" % (
                other.name, cloud.frame, cloud.name, other.frame, ", ".join(known) if known else "none"),
            "record these transforms, or leave the topic out")
    return mount.T_B_L @ chain.T_A_B, "transforms " + " -> ".join(chain.frames)


def _source_of(odometry: TopicSurvey | None, imu: TopicSurvey | None) -> str:
    if odometry is not None:
        return "child_frame_id on %s" % odometry.name
    return "frame of the IMU on %s" % imu.name if imu is not None else "frame of the clouds"


def _body_frame(survey: Survey, cloud: TopicSurvey, odometry: TopicSurvey | None, imu: TopicSurvey | None,
                notes: list[Problem]) -> str:
    if odometry is None:
        return cloud.frame if imu is None else imu.frame
    if odometry.child:
        return odometry.child
    below = [frame for frame in survey.frames.children(odometry.frame)
             if survey.frames.chain(frame, cloud.frame) is not None]
    body = survey.frames.root(below[0] if below else cloud.frame)
    if body == cloud.frame and cloud.frame not in survey.frames.frames():
        return ""
    notes.append(Problem(
        "the odometry on %s does not name its body (child_frame_id is empty): it is taken to be '%s', the root of the "
        "frames below which the LiDAR sits" % (odometry.name, body),
        "if that is right, nothing; else give where the LiDAR sits on the body with --mount, and let the node that "
        "publishes the odometry set child_frame_id"))
    return body


def _lidar_on_body(survey: Survey, cloud: TopicSurvey, body: str, odometry: TopicSurvey | None,
                   imu: TopicSurvey | None) -> tuple[Array, str]:
    if body and body == cloud.frame:
        return np.eye(4), "poses are those of the clouds' own frame '%s'" % body
    chain = survey.frames.chain(body, cloud.frame)
    if chain is None:
        survey.see_all_frames()
        chain = survey.frames.chain(body, cloud.frame)
    if chain is None:
        raise DatasetError(_unknown(survey, cloud, body, _source_of(odometry, imu)),
                           HOW_TO_SET + (_WITHOUT_IMU if odometry is None else ""))
    return chain.T_A_B, "transforms " + " -> ".join(chain.frames)


def _unknown(survey: Survey, cloud: TopicSurvey, body: str, source: str) -> str:
    text = ("nothing says where the LiDAR sits: there is no chain of transforms that do not move from the body '%s' "
            "(%s) to '%s' (frame of the clouds on %s)" % (body, source, cloud.frame, cloud.name))
    moving = survey.frames.moving_between(body, cloud.frame)
    if moving:
        text += "; on the way " + " and ".join("'%s' moves against '%s'" % (b, a) for a, b in moving)
    known = survey.frames.frames()
    return text + "; frames on /tf and /tf_static: %s" % (", ".join(known) if known else "none")


def _imu_on_body(survey: Survey, cloud: TopicSurvey, body: str, imu: TopicSurvey, T_B_L: Array) -> Array | None:
    """Returns the rotation of the IMU on the body, directly or over the LiDAR, or None if no transform gives it."""
    if imu.frame and imu.frame == body:
        return np.eye(3)
    direct = survey.frames.chain(body, imu.frame)
    if direct is not None:
        return direct.T_A_B[:3, :3]
    by_lidar = survey.frames.chain(cloud.frame, imu.frame)
    if by_lidar is not None:
        R: Array = T_B_L[:3, :3] @ by_lidar.T_A_B[:3, :3]
        return R
    return T_B_L[:3, :3] if imu.frame == cloud.frame else None
