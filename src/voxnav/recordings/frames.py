# SPDX-License-Identifier: BSD-3-Clause
"""Finds mounts of sensors from the transforms of a recording, as chains of links that do not move."""

from __future__ import annotations

from collections import deque
from typing import Any, Dict, Iterator, NamedTuple

import numpy as np

import voxnav
from voxnav.array_types import Array
from voxnav.recordings.bag_files import RawMessage, frame_name
from voxnav.recordings.errors import Problem
from voxnav.recordings.left_out import LeftOut

# A link that changes by less counts as one that does not move, because publishers round, and mounts may be estimated.
_SAME_M, _SAME_RAD = 1e-3, 1e-3

# This bounds the memory, and no vehicle has as many frames.
_MAX_LINKS = 2000


class _Link(NamedTuple):
    T_parent_child: Array
    is_moving: bool
    is_static: bool  # from /tf_static, where a later message replaces an earlier one
    way_m: float = 0.0  # the length of the way that the child has moved in its parent


class Chain(NamedTuple):
    """The transform T_A_B between two frames, and the frames from A to B."""

    T_A_B: Array
    frames: list[str]


def _pose(transform: Any) -> Array:
    """Returns a Transform as (4, 4). Raises ValueError if it is not finite or its quaternion is zero."""
    q, p = transform.rotation, transform.translation
    return voxnav.pose_from_quaternion((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def links_of(message: RawMessage, left_out: LeftOut) -> Iterator[tuple[tuple[str, str], int, Array]]:
    """Yields ((parent, child), stamp in ns, T_parent_child (4, 4)) for each link of a tf message.

    Links that are not rigid transforms are left out and counted.
    """
    try:
        transforms = message.make().transforms
    except ValueError as error:
        left_out.add("transform", str(error), message.record_ns)
        return
    for link in transforms:
        parent, child = frame_name(link.header.frame_id), frame_name(link.child_frame_id)
        try:
            if not parent or not child or parent == child:
                raise ValueError("its frames must have two different names")
            yield (parent, child), link.header.stamp.to_nsec(), _pose(link.transform)
        except ValueError as error:
            left_out.add("transform", "that from %s to %s is not one: %s" % (parent, child, error), message.record_ns)


def _is_same(a: Array, b: Array) -> bool:
    turn = np.arccos(np.clip((np.trace(a[:3, :3].T @ b[:3, :3]) - 1.0) / 2.0, -1.0, 1.0))
    return bool(np.linalg.norm(a[:3, 3] - b[:3, 3]) < _SAME_M and turn < _SAME_RAD)


class FrameGraph:
    """The links between frames, by the names of their ends without leading slashes. Their number is bounded."""

    def __init__(self) -> None:
        self.warnings: list[Problem] = []
        self._links: Dict[tuple[str, str], _Link] = {}

    def add_message(self, message: RawMessage, left_out: LeftOut) -> None:
        """Adds all links of a tf message; those that are not rigid transforms are left out and counted."""
        is_static = message.topic.endswith("tf_static")
        for (parent, child), _, T_parent_child in links_of(message, left_out):
            self.add(parent, child, T_parent_child, is_static)

    def add(self, parent: str, child: str, T_parent_child: Array, is_static: bool = True) -> None:
        """Adds a link each time it is sent. Raises ValueError for a frame without name or that is its own parent."""
        if not parent or not child or parent == child:
            raise ValueError("its frames must have two different names")
        if (child, parent) in self._links:
            parent, child, T_parent_child = child, parent, np.linalg.inv(T_parent_child)
        known = self._links.get((parent, child))
        if known is None:
            if len(self._links) < _MAX_LINKS:
                self._links[(parent, child)] = _Link(T_parent_child, False, is_static)
        elif not _is_same(known.T_parent_child, T_parent_child):
            way_m = known.way_m + float(np.linalg.norm(T_parent_child[:3, 3] - known.T_parent_child[:3, 3]))
            is_moving = not (is_static and known.is_static)
            self._replace(parent, child, known, _Link(T_parent_child, is_moving, is_static, way_m))

    def _replace(self, parent: str, child: str, known: _Link, new: _Link) -> None:
        """Replaces a link. If a static link differs, it was published twice, and as in tf2 the later one counts."""
        if new.is_moving:
            self._links[(parent, child)] = new
        elif not known.is_moving:
            self._links[(parent, child)] = new
            self._warn(Problem(
                "the static transform from %s to %s was sent with different values; the last one is used" % (
                    parent, child),
                "if the last one is wrong, end the node that sends it before the next flight; for this recording, give "
                "the mount with --mount"))

    def _warn(self, problem: Problem) -> None:
        if problem not in self.warnings and len(self.warnings) < 20:
            self.warnings.append(problem)

    def frames(self) -> list[str]:
        return sorted({name for ends in self._links for name in ends})

    def chain(self, a: str, b: str) -> Chain | None:
        """Returns T_a_b over links that do not move, or None if there is no such chain or a has no name. O(links)."""
        previous = self._paths_from(a, with_moving=False)
        if not a or b not in previous:
            return None
        frames = _path_to(b, previous)
        T = np.eye(4)
        for one, other in zip(frames, frames[1:]):
            T = T @ self.step(one, other)
        return Chain(T, frames)

    def moving_between(self, a: str, b: str) -> list[tuple[str, str]]:
        """Returns the moving links on a chain from a to b; the list is empty if there is no chain."""
        frames = self.path(a, b)
        return [ends for ends in zip(frames, frames[1:]) if self.is_moving(*ends)]

    def path(self, a: str, b: str) -> list[str]:
        """Returns the frames from a to b over links of any kind; the list is empty if there is no chain."""
        previous = self._paths_from(a, with_moving=True)
        return _path_to(b, previous) if b in previous else []

    def root(self, frame: str) -> str:
        """Returns the uppermost ancestor of a frame over links that do not move, or the frame itself if it has none."""
        seen = {frame}
        while True:
            parents = [p for (p, c), link in sorted(self._links.items()) if c == frame and not link.is_moving]
            if not parents or parents[0] in seen:
                return frame
            frame = parents[0]
            seen.add(frame)

    def children(self, frame: str) -> list[str]:
        """Returns the frames at the other ends of moving links of a frame, in whichever direction they were sent."""
        ends = [(p, c) for (p, c), link in sorted(self._links.items()) if link.is_moving and frame in (p, c)]
        return [c if p == frame else p for p, c in ends]

    def moving_parents(self, frame: str) -> list[str]:
        """Returns the frames of which this one is a moving child."""
        return [p for (p, c), link in sorted(self._links.items()) if link.is_moving and c == frame]

    def ends(self, a: str, b: str) -> tuple[str, str]:
        """Returns two linked frames as (parent, child), as the link was sent first. Raises KeyError for others."""
        if (a, b) not in self._links and (b, a) not in self._links:
            raise KeyError("%s, %s" % (a, b))
        return (a, b) if (a, b) in self._links else (b, a)

    def is_moving(self, a: str, b: str) -> bool:
        """Returns whether the link between two linked frames moves."""
        return self._links[self.ends(a, b)].is_moving

    def way_m(self, a: str, b: str) -> float:
        """Returns the length of the way on which one of two linked frames moved in the other."""
        return self._links[self.ends(a, b)].way_m

    def step(self, a: str, b: str) -> Array:
        """Returns T_a_b (4, 4) of two linked frames as it was sent last."""
        if (a, b) in self._links:
            return self._links[(a, b)].T_parent_child
        inverse: Array = np.linalg.inv(self._links[(b, a)].T_parent_child)
        return inverse

    def _paths_from(self, a: str, with_moving: bool) -> dict[str, str | None]:
        """Returns for each frame the one before it on the shortest path from a."""
        neighbours: dict[str, list[str]] = {}
        for (parent, child), link in self._links.items():
            if with_moving or not link.is_moving:
                neighbours.setdefault(parent, []).append(child)
                neighbours.setdefault(child, []).append(parent)
        previous: dict[str, str | None] = {a: None}
        waiting = deque([a])
        while waiting:
            frame = waiting.popleft()
            for other in sorted(neighbours.get(frame, [])):
                if other not in previous:
                    previous[other] = frame
                    waiting.append(other)
        return previous


def _path_to(b: str, previous: dict[str, str | None]) -> list[str]:
    frames, frame = [], b
    while frame is not None:
        frames.append(frame)
        frame = previous[frame]  # type: ignore[assignment]
    return frames[::-1]
