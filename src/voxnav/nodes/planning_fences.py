# SPDX-License-Identifier: BSD-3-Clause
"""The fences of the planner: reads their files, serves no-fly zones, keeps all of them placed, and draws them."""

import functools
import threading

import numpy as np
import rospy
from geometry_msgs.msg import Point
from mrs_msgs.srv import String, StringResponse
from std_srvs.srv import Trigger, TriggerResponse
from visualization_msgs.msg import Marker, MarkerArray

from voxnav.fences import FenceBook, FenceError, FencePrism, Limits, place
from voxnav.nodes.planning_output import marker
from voxnav.srv import AddZone, AddZoneResponse

# Fences are placed anew this often, because the transforms between the frames of MRS change.
PLACE_INTERVAL_S = 1.0
AREA_COLOUR, ZONE_COLOUR, ZONE_WALL_COLOUR = (0.2, 0.8, 1.0, 0.9), (1.0, 0.3, 0.2, 0.9), (1.0, 0.3, 0.2, 0.3)
LINE_M = 0.1


class PlanningFences:
    """Calls set_fences(placed, problem) whenever the fences have changed or moved in the odometry frame.

    config: voxnav.FencesConfig; inputs: PlanningInputs; seam: the time seam. A file that cannot be read is a problem
    that keeps the vehicle where it is.
    """

    def __init__(self, config, inputs, uav_name, set_fences, seam):
        self._inputs, self._uav_name, self._set_fences, self._seam = inputs, uav_name, set_fences, seam
        self._book = FenceBook(Limits(config.max_zones, config.max_corners, config.max_zone_size_m,
                                      config.max_area_size_m))
        self._lock = threading.RLock()  # services come in threads of their own
        self._placed = self._placed_at = None
        self._frame = ""  # the odometry frame in which they are placed
        self._problem = ""
        self._file_problem = self._load(config)
        self._markers = rospy.Publisher("~fence_markers_out", MarkerArray, queue_size=1, latch=True)
        rospy.Service("~add_zone", AddZone, self._serve_add)
        for name, serve in (("remove_zone", self._remove), ("load_zones", self._load_zones),
                            ("save_zones", self._save_zones)):
            rospy.Service("~" + name, String, functools.partial(self._serve_string, serve))
        rospy.Service("~clear_zones", Trigger, lambda _: self._answer(TriggerResponse, self._clear))
        self.update(is_due=True)

    def _load(self, config):
        """Reads the files of the configuration. Returns why they cannot be used, '' if they can."""
        try:
            if config.world_config:
                self._book.load_world(config.world_config)
            if config.zones_file:
                self._book.load_zones(config.zones_file)
        except FenceError as error:
            rospy.logerr("fences: %s", error)
            return "fences cannot be used: " + str(error).splitlines()[0]
        return ""

    # Placing

    def update(self, is_due=False):
        """Places the fences anew if it is time; to be called by the main loop."""
        with self._lock:
            if self._inputs.odometry_frame != self._frame:
                # In the origin of another estimator they are elsewhere: where they were placed before tells nothing.
                self._frame, self._placed, is_due = self._inputs.odometry_frame, None, True
            if not is_due and self._placed_at is not None and self._seam.elapsed_s(self._placed_at) < PLACE_INTERVAL_S:
                return
            self._placed_at = self._seam.mark()
            problem, placed = self._file_problem, None
            if not problem and not self._book.is_empty:
                try:
                    placed = place(self._book, self.T_O)
                except FenceError as error:
                    problem = "fences cannot be placed: %s" % error
            self._take(placed, problem)

    def _take(self, placed, problem):
        # Fences that were placed once stay where they are while a transform is missing.
        if problem and not self._file_problem and self._placed is not None:
            if self._placed.version == self._book.version:
                rospy.logwarn_throttle(10.0, problem)
                return
        is_same = placed is self._placed is None or (placed is not None and placed.is_like(self._placed))
        if is_same and problem == self._problem:
            return
        if problem and problem != self._problem:
            rospy.logwarn(problem)
        self._problem = problem
        self._placed = self._placed if is_same else placed
        self._set_fences(self._placed, problem)
        self._draw()

    @property
    def world_origin(self):
        """The voxnav.fences.WorldOrigin of the world configuration; None if there is none."""
        return self._book.world.origin

    def T_O(self, frame):
        """Returns T_O_F of a frame, whose short name belongs to this UAV. Raises FenceError."""
        return self.timed_T_O(frame)[0]

    def timed_T_O(self, frame):
        """Returns T_O_F as T_O(), and when tf told it [s]; None if it holds at all times. Raises FenceError."""
        inputs = self._inputs
        names = [frame] if "/" in frame or not self._uav_name else [frame, self._uav_name + "/" + frame]
        if not inputs.odometry_frame:
            raise FenceError("no odometry yet")
        if inputs.odometry_frame in names:
            return np.eye(4), None
        if inputs.map_frame in names:
            if inputs.T_W_O is None:
                raise FenceError("no map correction yet")
            return np.linalg.inv(inputs.T_W_O), None
        try:
            return inputs.timed_T_O_of(frame, names)
        except LookupError as error:
            raise FenceError(str(error))

    # Services

    def add(self, zone):
        """Adds a FencePrism. Returns a sentence about it; raises FenceError."""
        self._change(lambda book: book.add(zone))
        position = self._inputs.position_O
        contact = None if position is None else self._placed.fences.contact(position)
        where = "" if contact is None else "; the vehicle is %s and stays where it is" % self._placed.what(contact)
        return "zone %s is in force%s" % (zone.name, where)

    def _change(self, change):
        """Changes the book, and places it. Returns what change(book) does; after a FenceError all is as before."""
        with self._lock:
            book = self._book.copy()
            out = change(book)
            place(book, self.T_O)
            self._book = book
            self.update(is_due=True)
            return out

    def clear(self, prefix=""):
        """Removes the zones whose names begin with a prefix. Returns how many there were."""
        return self._change(lambda book: book.clear(prefix))

    def _serve_string(self, serve, request):
        return self._answer(StringResponse, serve, request.value)

    def _serve_add(self, request):
        outline = np.array([(p.x, p.y) for p in request.outline]).reshape(-1, 2)
        zone = FencePrism(request.name, request.frame_id, outline, request.vertical_frame_id or request.frame_id,
                          request.min_z, request.max_z)
        return self._answer(AddZoneResponse, self.add, zone)

    def _answer(self, response, serve, *arguments):
        try:
            with self._lock:
                message = serve(*arguments)
        except FenceError as error:
            rospy.logwarn("fences: %s", error)
            return response(success=False, message=str(error))
        rospy.loginfo("fences: %s", message)
        return response(success=True, message=message)

    def _remove(self, name):
        self._change(lambda book: book.remove(name))
        return "zone %s is removed" % name

    def _clear(self):
        return "%d zones are removed" % self.clear()

    def _load_zones(self, path):
        number = self._change(lambda book: book.load_zones(path))
        return "%d zones of %s are in force" % (number, path)

    def _save_zones(self, path):
        return "%d zones are written to %s" % (self._book.save_zones(path), path)

    # Markers

    def _draw(self):
        markers = [Marker(action=Marker.DELETEALL)]
        if self._placed is not None:
            fences = self._placed.fences
            if fences.area is not None:
                markers.append(self._edges("safety area", AREA_COLOUR, fences.area))
            for name, zone in zip(self._placed.names, fences.zones):
                # Edges alone disappear among the voxels of the map; the area has none, because one looks through it.
                markers += [self._edges("zone " + name, ZONE_COLOUR, zone), self._walls("zone %s walls" % name, zone)]
        self._markers.publish(MarkerArray(markers=markers))

    def _edges(self, name, colour, prism):
        return marker(self._inputs.odometry_frame, rospy.Time(0), name, Marker.LINE_LIST, colour, LINE_M,
                      corner_points(edges_of(prism)))

    def _walls(self, name, prism):
        return marker(self._inputs.odometry_frame, rospy.Time(0), name, Marker.TRIANGLE_LIST, ZONE_WALL_COLOUR, 1.0,
                      corner_points(walls_of(prism)))


def corner_points(corners):
    return [Point(*(float(x) for x in corner)) for corner in corners]


def walls_of(prism):
    """Returns the corners of the triangles of the sides of a voxnav.Prism, (n, 3).

    Each triangle comes twice, because rviz lights it from one side only and shows the other one black.
    """
    low, high = prism.min_z, prism.max_z
    corners = []
    for (x0, y0), (x1, y1) in zip(prism.outline, np.roll(prism.outline, -1, axis=0)):
        corners += [(x0, y0, low), (x1, y1, low), (x1, y1, high), (x0, y0, low), (x1, y1, high), (x0, y0, high)]
    return np.array(corners + corners[::-1])


def edges_of(prism):
    """Returns the ends of all edges of a voxnav.Prism in pairs, (n, 3)."""
    begins = prism.outline
    ends = np.roll(begins, -1, axis=0)
    lines = []
    for (x0, y0), (x1, y1) in zip(begins, ends):
        low, high = prism.min_z, prism.max_z
        lines += [(x0, y0, low), (x1, y1, low), (x0, y0, high), (x1, y1, high), (x0, y0, low), (x0, y0, high)]
    return np.array(lines)
