# SPDX-License-Identifier: BSD-3-Clause
"""Inputs of the planner: grids, and heartbeats of other nodes."""

import collections
import threading

import numpy as np
import rospy

import voxnav
from voxnav.msg import GridUpdate, NodeDiagnostics
from voxnav.nodes.planning_services import ServiceError, TimedService
from voxnav.srv import GetGrid, GetGridRequest

SNAPSHOT_INTERVAL_S = 1.0


class GridFeed:
    """Applies one GridUpdate topic to a layer of the NavigationMap; requests a snapshot if a change was missed."""

    def __init__(self, topic, service, apply, on_applied, timeout_s, seam):
        """Subscribes. on_applied(stamp_s) is called for every update that has been applied."""
        self._apply, self._on_applied, self._seam = apply, on_applied, seam
        self._service = TimedService(service, GetGrid, timeout_s, seam)
        self._recent = collections.deque(maxlen=30)  # changes that come while the snapshot is on its way
        self._lock = threading.Lock()
        self._is_fetching, self._fetched = False, None
        self.num_snapshots = self.num_refused = 0
        self.frame = ""
        self._subscriber = rospy.Subscriber(topic, GridUpdate, self._on_update, queue_size=20, buff_size=1 << 22)

    def _on_update(self, msg):
        self.receive(msg)

    def receive(self, msg):
        with self._lock:
            self._recent.append(msg)
            if self._take(msg) != voxnav.Applied.NEEDS_SNAPSHOT or self._is_fetching or self._has_just_fetched():
                return
            self._is_fetching = True
        threading.Thread(target=self._fetch, daemon=True).start()

    def _has_just_fetched(self):
        return self._fetched is not None and self._seam.elapsed_s(self._fetched) < SNAPSHOT_INTERVAL_S

    def _take(self, msg):
        try:
            result = self._apply(sequence=msg.sequence, resolution_m=msg.resolution_m,
                                 block_indices=np.array(msg.block_indices, dtype=np.int32), states=msg.states,
                                 removed=np.array(msg.removed_block_indices, dtype=np.int32),
                                 is_snapshot=msg.is_snapshot)
        except ValueError as error:
            self.num_refused += 1
            rospy.logerr_throttle(1.0, "grid update refused: %s", error)
            return voxnav.Applied.NEEDS_SNAPSHOT
        if result == voxnav.Applied.APPLIED:
            self.frame = msg.header.frame_id
            self._on_applied(msg.header.stamp.to_sec())
        return result

    def _fetch(self):
        try:
            response = self._service.call(GetGridRequest())
        except ServiceError as error:
            response = None
            rospy.logwarn_throttle(5.0, "no snapshot: %s", error)
        with self._lock:
            self._is_fetching, self._fetched = False, self._seam.mark()
            if response is None or not response.success:
                return
            self.num_snapshots += 1
            response.grid.is_snapshot = True
            self._take(response.grid)
            for msg in self._recent:
                if msg.sequence > response.grid.sequence:
                    self._take(msg)


class LocalGridFeed(GridFeed):
    """The GridFeed of the local map, with what its newest sweep showed beside the map."""

    def __init__(self, topic, service, navigation_map, on_applied, timeout_s, seam):
        super().__init__(topic, service, navigation_map.apply_local, on_applied, timeout_s, seam)
        self._map = navigation_map

    def _take(self, msg):
        try:
            self._map.set_sightings(stamp_s=msg.header.stamp.to_sec(), resolution_m=msg.resolution_m,
                                    hits=np.array(msg.new_hits, dtype=np.int32).reshape(-1, 3),
                                    returns=np.array(msg.new_hit_returns, dtype=np.int32),
                                    things=np.array([_row(thing) for thing in msg.moving_things]).reshape(-1, 12))
        except ValueError as error:
            self.num_refused += 1
            rospy.logerr_throttle(1.0, "sightings refused: %s", error)
        return super()._take(msg)


def _row(thing):
    """Returns the numbers of a MovingThing as NavigationMap.set_sightings takes them."""
    p, v, h = thing.position, thing.velocity, thing.half_size_m
    return [float(thing.id), p.x, p.y, p.z, v.x, v.y, v.z, h.x, h.y, h.z, thing.position_sigma_m,
            thing.velocity_sigma_mps]


class WaitingGridFeed(GridFeed):
    """A GridFeed whose updates are delivered by the time seam."""

    def _on_update(self, msg):
        self._seam.deliver(msg.header.stamp.to_sec(), self.receive, msg)


class Heartbeats:
    """Watches which of the required nodes are gone (nobody publishes their diagnostics) or silent."""

    def __init__(self, names, timeout_s, seam):
        self._timeout_s, self._seam = timeout_s, seam
        self._heard = {name: None for name in names}  # times of the last diagnostics, by the seam's clock
        self._topics = {name: rospy.Subscriber(name + "/diagnostics", NodeDiagnostics, self._on_message,
                                               callback_args=name, queue_size=2) for name in names}

    def _on_message(self, _, name):
        self._heard[name] = self._seam.mark()

    def lost(self):
        for name, topic in self._topics.items():
            if topic.get_num_connections() == 0:
                self._heard[name] = None  # a node that comes back has to publish diagnostics again
        return [name for name, heard in self._heard.items()
                if heard is None or self._seam.elapsed_s(heard) > self._timeout_s]
