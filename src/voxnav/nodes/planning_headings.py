# SPDX-License-Identifier: BSD-3-Clause
"""Headings of the waypoints of which the generator makes trajectories."""

import numpy as np

import voxnav

# A way that leads less far horizontally has no direction.
LEAST_WAY_M = 1e-3


def directions_rad(points, look_ahead_m, present_rad):
    """Returns the direction of flight at each point of a path, that to the path look_ahead_m farther on.

    points: (n, 3). Where the path is vertical the direction before holds, at first present_rad; at the end, too.
    """
    points = np.asarray(points, dtype=float)
    arcs_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    out, direction = [], present_rad
    for point, arc_m in zip(points, arcs_m):
        ahead = [np.interp(arc_m + look_ahead_m, arcs_m, points[:, axis]) for axis in range(2)]
        way = np.asarray(ahead) - point[:2]
        if np.linalg.norm(way) > LEAST_WAY_M:
            direction = float(np.arctan2(way[1], way[0]))
        out.append(direction)
    return out


def with_turns(points, look_ahead_m, ends_otherwise):
    """Returns a path with a point in each long segment by which the vehicle has turned into its direction.

    ends_otherwise: the heading at the end is another one, so another point tells where the vehicle begins to turn to it
    """
    points = np.asarray(points, dtype=float)
    out = [points[0]]
    for number, (begin, end) in enumerate(zip(points[:-1], points[1:])):
        length_m = float(np.linalg.norm(end - begin))
        if length_m > 2.0 * look_ahead_m:
            out.append(begin + look_ahead_m / length_m * (end - begin))
            if ends_otherwise and number == len(points) - 2:
                out.append(end - look_ahead_m / length_m * (end - begin))
        out.append(end)
    return np.array(out)


class Headings:
    """What a path says about headings, by the section `heading` of the parameters (voxnav.HeadingConfig)."""

    def __init__(self, config):
        self._config = config

    def apply(self, path, waypoints, goal_heading_rad, present_rad):
        """Sets use_heading and relax_heading of a mrs_msgs/Path. Returns its points, (k, 3), and their headings, (k,).

        waypoints: (n, 3) frame O; goal_heading_rad: heading wanted at the last one, or None; present_rad: heading of
        the vehicle, or None if it is not known
        """
        mode, waypoints = self._config.mode, np.asarray(waypoints, dtype=float)
        if mode == voxnav.HeadingMode.FLIGHT_DIRECTION and present_rad is not None:
            path.use_heading, path.relax_heading = True, self._config.is_relaxed
            points = with_turns(waypoints, self._config.look_ahead_m, goal_heading_rad is not None)
            # The directions do not contain the offset, and the present heading does.
            before_rad = present_rad - self._config.offset_rad
            directions = directions_rad(points, self._config.look_ahead_m, before_rad)
            headings = [direction + self._config.offset_rad for direction in directions]
            if goal_heading_rad is not None:
                headings[-1] = goal_heading_rad
            return points, headings
        path.use_heading = goal_heading_rad is not None and mode != voxnav.HeadingMode.FIXED
        # Otherwise the generator would slow the flight down to turn to the heading 0 of every waypoint.
        path.relax_heading = not path.use_heading
        return waypoints, [goal_heading_rad if path.use_heading else 0.0] * len(waypoints)
