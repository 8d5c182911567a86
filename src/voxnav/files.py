# SPDX-License-Identifier: BSD-3-Clause
"""Plain file formats: TUM trajectories and PLY clouds."""

from __future__ import annotations

from typing import Iterable, Iterator, Sequence

import numpy as np

import voxnav
from voxnav.array_types import Array, ArrayLike


def rotation_from_quaternion(q_xyzw: ArrayLike) -> Array:
    """Returns the (3, 3) rotation of a quaternion (4,) x y z w of any norm > 0. Raises ValueError for others."""
    q = np.asarray(q_xyzw, dtype=np.float64)
    norm = np.linalg.norm(q)
    if not np.isfinite(norm) or norm < 1e-6:
        raise ValueError("quaternion %s has no direction" % (q,))
    x, y, z, w = q / norm
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def quaternion_from_rotation(R: Array) -> Array:
    """Returns the quaternion (4,) x y z w with w >= 0 of a (3, 3) rotation.

    Source: Shepperd, Quaternion from rotation matrix, Journal of Guidance and Control 1978.
    """
    candidates = np.array([R[0, 0], R[1, 1], R[2, 2], np.trace(R)])
    k = int(np.argmax(candidates))
    if k == 3:
        q = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], 1.0 + candidates[3]])
    else:
        i, j, m = k, (k + 1) % 3, (k + 2) % 3
        q = np.empty(4)
        q[i] = 1.0 + R[i, i] - R[j, j] - R[m, m]
        q[j] = R[j, i] + R[i, j]
        q[m] = R[m, i] + R[i, m]
        q[3] = R[m, j] - R[j, m]
    q /= np.linalg.norm(q)
    return q if q[3] >= 0 else -q


def pose_from_tum_row(row: Sequence[float]) -> Array:
    T = np.eye(4)
    T[:3, :3] = rotation_from_quaternion(row[4:8])
    T[:3, 3] = row[1:4]
    return T


def _rows(path: str) -> Iterator[tuple[int, list[str]]]:
    """Lines of a text file with their numbers, as words between blanks or commas, without comments. Raises ValueError
    naming the first line that is no text."""
    with open(path, "rb") as source:
        for number, line in enumerate(source, 1):
            try:
                words = line.decode("utf-8-sig" if number == 1 else "utf-8").split("#")[0].replace(",", " ").split()
            except UnicodeDecodeError:
                raise ValueError("%s line %d: it is no text" % (path, number))
            if words:
                yield number, words


def read_numbers(path: str) -> Array:
    """Returns the numbers (n,) float64 of a file with one per line. Raises ValueError naming file and line."""
    out = []
    for number, words in _rows(path):
        try:
            if len(words) != 1 or not np.isfinite(float(words[0])):
                raise ValueError("needs one finite number, has '%s'" % " ".join(words))
            out.append(float(words[0]))
        except ValueError as error:
            raise ValueError("%s line %d: %s" % (path, number, error))
    return np.array(out)


def read_tum(path: str) -> tuple[Array, Array]:
    """Reads rows ``t x y z qx qy qz qw`` with blanks or commas between. Returns (stamps (n,) s, poses (n, 4, 4)).

    Raises ValueError naming file and line.
    """
    stamps: list[float] = []
    poses = []
    for number, words in _rows(path):
        try:
            row = [float(word) for word in words]
            if len(row) != 8 or not np.all(np.isfinite(row)):
                raise ValueError("needs eight finite numbers t x y z qx qy qz qw")
            poses.append(pose_from_tum_row(row))
            if stamps and row[0] <= stamps[-1]:
                raise ValueError("time does not increase, %s after %s" % (words[0], repr(stamps[-1])))
        except ValueError as error:
            raise ValueError("%s line %d: %s" % (path, number, error))
        stamps.append(row[0])
    if not stamps:
        raise ValueError("%s holds no poses" % path)
    return np.array(stamps), np.array(poses)


def write_tum(path: str, stamps: Iterable[float], poses: Iterable[Array]) -> None:
    """Writes a TUM trajectory with nine decimals of time and position, so that equal runs give equal bytes."""
    with open(path, "w") as out:
        for stamp, T in zip(stamps, poses):
            q = quaternion_from_rotation(T[:3, :3])
            out.write("%.9f %s\n" % (stamp, " ".join("%.9f" % (v + 0.0) for v in (*T[:3, 3], *q))))


def write_ply_points(path: str, points: ArrayLike, colors: ArrayLike | None = None) -> None:
    """Writes a binary PLY. points: (n, 3), metres; colors: (n, 3) red, green and blue from 0 to 255, or None."""
    points = np.ascontiguousarray(points, dtype=np.float32).reshape(-1, 3)
    if colors is not None:
        colors = np.ascontiguousarray(colors, dtype=np.uint8).reshape(-1, 3)
    voxnav.write_ply_points(str(path), points, colors)
