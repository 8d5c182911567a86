# SPDX-License-Identifier: BSD-3-Clause
"""Finds the transforms on /tf that are the poses of the body, for recordings without messages of odometry."""

from __future__ import annotations

from typing import NamedTuple, Tuple

from voxnav.recordings.bag_files import TF_TOPICS
from voxnav.recordings.errors import DatasetError
from voxnav.recordings.frames import FrameGraph
from voxnav.recordings.survey import Survey, TopicSurvey

# A link whose ends move by less in the whole recording is a joint rather than the way of a vehicle.
_MIN_WAY_M = 0.3
# Parts of the usual names of frames in which odometry is continuous, and of those in which it is not (REP 105).
_ODOMETRY_NAMES, _ORIGIN_NAMES = ("odom",), ("odom", "origin", "map", "world")

Ends = Tuple[str, str]


class TfPath(NamedTuple):
    """frames: from the origin O of the poses to the body B, each linked to the next; topic: that of the links."""

    topic: str
    frames: list[str]

    @property
    def origin(self) -> str:
        return self.frames[0]

    @property
    def body(self) -> str:
        return self.frames[-1]


def find_tf_path(survey: Survey, cloud: TopicSurvey, wanted_origin: str = "") -> TfPath | None:
    """Returns the path from an origin to the body below which the LiDAR sits, or None if none moves like a vehicle.

    wanted_origin: the frame of the poses that the user wants. Raises DatasetError if no transforms lead to it.
    """
    topics = [name for name in TF_TOPICS if name in survey.all_topics and not name.endswith("tf_static")]
    if not topics or not cloud.frame:
        return None
    frames = survey.frames
    if wanted_origin and wanted_origin.lstrip("/") not in frames.frames():
        survey.see_all_frames()
    body = frames.root(cloud.frame)
    origin = wanted_origin.lstrip("/") or _origin_above(frames, body) or _origin_below(frames, body)
    if not origin:
        return None
    path = frames.path(origin, body)
    if wanted_origin and len(path) < 2:
        raise DatasetError("no transforms lead from '%s' (run/odometry_frame) to '%s', on which the LiDAR sits" % (
            origin, body), "frames on /tf and /tf_static: %s" % (", ".join(frames.frames()) or "none"))
    return TfPath(topics[0], path)


def _is_named(frame: str, names: Tuple[str, ...]) -> bool:
    return any(name in frame.split("/")[-1].lower() for name in names)


def _origin_above(frames: FrameGraph, body: str) -> str:
    """Returns the frame of continuous odometry among the ancestors of the body, or "" if the body travels in none.

    It is known by its name, else it is the upper end of the link that moves farthest: links above it correct drift, and
    links below it are joints of the vehicle.
    """
    found: list[tuple[str, float]] = []
    at, seen = body, {body}
    while True:
        parents = frames.moving_parents(at)
        if not parents or parents[0] in seen:
            break
        found.append((parents[0], frames.way_m(parents[0], at)))
        seen.add(parents[0])
        at = frames.root(parents[0])
    if sum(way_m for _, way_m in found) < _MIN_WAY_M:
        return ""
    named = [frame for frame, _ in found if _is_named(frame, _ODOMETRY_NAMES)]
    return named[0] if named else max(found, key=lambda each: each[1])[0]


def _origin_below(frames: FrameGraph, body: str) -> str:
    """Returns the origin among the children of the body, as in the inverted trees of the MRS system, or ""."""
    found = [frame for frame in frames.children(body) if frames.way_m(body, frame) >= _MIN_WAY_M
             and _is_named(frame, _ORIGIN_NAMES)]
    named = [frame for frame in found if _is_named(frame, _ODOMETRY_NAMES)]
    return min(named or found, default="")
