# SPDX-License-Identifier: BSD-3-Clause
"""The submap_optimizer node: optimises the graph of submaps and publishes their poses.

Everything that touches the graph runs on one worker thread, so that a solve never blocks a callback.
"""

import math
import os
import queue
import threading
import time

import numpy as np
import rospy
from mrs_msgs.msg import Float64Stamped
from mrs_msgs.srv import String, StringResponse
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import NavSatFix
from std_srvs.srv import Trigger, TriggerResponse
from visualization_msgs.msg import MarkerArray

import voxnav
from voxnav.msg import (FinishedSubmap, LoopClosure, NodeDiagnostics, OdometryOrigin, OptimizerReport,
                        SubmapPoses)
from voxnav.nodes import graph_messages
from voxnav.nodes.correction_broadcast import CorrectionBroadcast
from voxnav.nodes.node_base import Diagnostics, run_node
from voxnav.nodes.params import load_sections
from voxnav.nodes.graph_origins import Change, GraphOrigins
from voxnav.nodes.time_seam import ProgressPublisher
from voxnav.optimizer_session import Height, OptimizerSession
from voxnav.srv import GetSubmaps

NAME = "submap_optimizer"
_ANSWER_TIMEOUT_S = 30.0
# The map correction kept on the parameter server is forgotten after this time.
KEPT_CORRECTION_AGE_S = 600.0


class SubmapOptimizer:
    """The node; see config/submap_optimizer.yaml for its parameters."""

    def __init__(self):
        self._graph_config, self._config, time_config = load_sections(
            graph=voxnav.SubmapGraphConfig, node=voxnav.OptimizerConfig, time=voxnav.TimeConfig)
        self._session = OptimizerSession(self._graph_config, self._config)
        self._diagnostics, self._progress = Diagnostics(NAME), ProgressPublisher(time_config, NAME)
        self._kept_name = rospy.get_name() + "_kept_correction"
        self._jobs = queue.Queue(maxsize=self._config.max_queue)
        self._fixes = graph_messages.FixReader()
        self._correction = CorrectionBroadcast(self._config.map_frame, self._config.tf_rate_hz)
        self._first_T_W_O = np.eye(4)
        self._origins = GraphOrigins(self._config.odometry_frame)  # those of T_W_O, of the worker
        self._closed_at, self._closed_because = rospy.Time(0), ""
        self._latest_stamp = rospy.Time(0)
        self._advertise()
        self._jobs.put(("restore", self._restore, ()))  # runs before the submaps that arrive from now on are added
        self._subscribe()
        threading.Thread(target=self._work, name="solver", daemon=True).start()

    def _advertise(self):
        def latched(topic, kind):
            return rospy.Publisher(topic, kind, queue_size=2, latch=True)

        self._poses_out = latched("~submap_poses_out", SubmapPoses)
        self._markers_out = latched("~graph_markers_out", MarkerArray)
        self._trajectory_out = latched("~trajectory_out", Path)
        self._report_out = latched("~report_out", OptimizerReport)
        rospy.Service("~optimize_in", Trigger, self._on_optimize)
        rospy.Service("~save_g2o_in", String, self._on_save)
        rospy.Service("~enable_kind_in", String, lambda request: self._on_kind(request.value, True))
        rospy.Service("~disable_kind_in", String, lambda request: self._on_kind(request.value, False))

    def _subscribe(self):
        rospy.Subscriber("~submap_in", FinishedSubmap, self._on_submap, queue_size=50)
        rospy.Subscriber("~origin_in", OdometryOrigin, self._on_origin, queue_size=5)
        rospy.Subscriber("~loop_closure_in", LoopClosure, self._on_loop, queue_size=50)
        rospy.Subscriber("~height_in", Float64Stamped, self._on_height, queue_size=50)
        if self._config.gnss_type == voxnav.GnssType.ODOMETRY:
            rospy.Subscriber("~gnss_in", Odometry, self._on_gnss_odometry, queue_size=50)
        elif self._config.gnss_type == voxnav.GnssType.NAVSATFIX:
            rospy.Subscriber("~gnss_in", NavSatFix, self._on_fix, queue_size=50)

    def _restore(self):
        """Restores the graph after a restart in flight from the integrator's submaps and the master's T_W_O."""
        try:
            first_T_W_O, last_T_W_O = self._kept_corrections()
            self._session.T_W_O = first_T_W_O
            if not self._restore_submaps():
                self._session.T_W_O = last_T_W_O
            self._first_T_W_O = first_T_W_O if self._session.records else last_T_W_O
            self._set_correction()
        finally:
            self._correction.start()

    def _kept_corrections(self):
        """Returns T_W_O when the first and the last submap were placed, since W must not move by a restart."""
        kept = rospy.get_param(self._kept_name, {})
        age_s = rospy.Time.now().to_sec() - kept.get("stamp_s", -math.inf)
        if not 0.0 <= age_s < KEPT_CORRECTION_AGE_S:
            return np.eye(4), np.eye(4)
        return tuple(voxnav.pose_from_yaw(np.array(kept[name][:3]), kept[name][3]) for name in ("first", "last"))

    def _keep_corrections(self):
        kept = {"stamp_s": rospy.Time.now().to_sec()}
        for name, T in (("first", self._first_T_W_O), ("last", self._session.T_W_O)):
            kept[name] = [float(x) for x in T[:3, 3]] + [voxnav.yaw_of(T)]
        rospy.set_param(self._kept_name, kept)

    def _set_correction(self):
        self._correction.set(self._origins.frame, np.linalg.inv(self._session.T_W_O))

    def _restore_submaps(self):
        """Requests the finished submaps from the integrator. Returns True if there are any."""
        try:
            rospy.wait_for_service("~get_submaps_out", timeout=2.0)
            answer = rospy.ServiceProxy("~get_submaps_out", GetSubmaps)()
        except (rospy.ROSException, rospy.ServiceException) as error:
            rospy.loginfo("[%s]: starting empty: %s", NAME, error)
            return False
        if not answer.success:
            rospy.logwarn("[%s]: starting empty: %s", NAME, answer.message)
            return False
        for msg in answer.submaps:
            self._take(msg)
        if not self._session.records:
            return False
        self._solve(full=True)
        rospy.loginfo("[%s]: restored %d submaps", NAME, len(self._session.records))
        return True

    # Callbacks: they only queue work for the worker.

    def _enqueue(self, stage, function, *arguments):
        try:
            self._jobs.put_nowait((stage, function, arguments))
            return True
        except queue.Full:
            self._diagnostics.add_dropped(stage)
            self._diagnostics.set_level(NodeDiagnostics.WARN, "the solver cannot keep up: %s dropped" % stage)
            return False

    def _on_submap(self, msg):
        self._enqueue("submap", self._add_submap, msg)

    def _on_origin(self, msg):
        self._enqueue("origin", self._take_origin, msg)

    def _on_loop(self, msg):
        self._enqueue("loop", self._add_loop, msg)

    def _on_gnss_odometry(self, msg):
        self._session.add_fix(graph_messages.fix_from_odometry(msg))

    def _on_fix(self, msg):
        fix = self._fixes.read(msg)
        if fix is None:
            self._diagnostics.add_dropped("gnss")
        else:
            self._session.add_fix(fix)

    def _on_height(self, msg):
        self._session.add_height(Height(msg.header.stamp.to_sec(), msg.value))

    def _ask(self, function, *arguments):
        """Runs a function on the worker thread and waits for it. Returns (success, message)."""
        answers = queue.Queue(maxsize=1)

        def job():
            try:
                answers.put((True, function(*arguments)))
            except (ValueError, OSError) as error:
                answers.put((False, str(error)))

        if not self._enqueue("service", job):
            return False, "the solver is busy and its queue is full"
        try:
            return answers.get(timeout=_ANSWER_TIMEOUT_S)
        except queue.Empty:
            return False, "no answer within %.0f s; the request stays in the queue" % _ANSWER_TIMEOUT_S

    def _on_optimize(self, _):
        return TriggerResponse(*self._ask(self._solve_and_tell))

    def _on_save(self, request):
        return StringResponse(*self._ask(self._save, request.value))

    def _on_kind(self, kind, is_enabled):
        return StringResponse(*self._ask(self._set_kind, kind, is_enabled))

    # The worker.

    def _work(self):
        while not rospy.is_shutdown():
            try:
                stage, function, arguments = self._jobs.get(timeout=0.5)
            except queue.Empty:
                continue
            try:
                function(*arguments)
            except Exception as error:  # noqa: B902: no input may end the thread
                self._diagnostics.add_dropped(stage)
                self._diagnostics.set_level(NodeDiagnostics.WARN, "%s refused: %s" % (stage, error))
                rospy.logwarn_throttle(1.0, "[%s]: %s refused: %s", NAME, stage, error)

    def _take_origin(self, msg):
        """Follows the odometry to another origin; closes the map if that does not relate to the one before."""
        frame, before = msg.header.frame_id, self._origins.frame
        change, T_new_old = self._origins.follow(msg)
        if change is Change.NONE:
            self._set_correction()
            return
        if change is Change.UNRELATED:
            because = "the odometry changed from %s to %s, which do not relate" % (before, frame)
            self._close_map(msg.header.stamp, because)
        else:
            self._session.change_origin(T_new_old)
            self._first_T_W_O = self._first_T_W_O @ np.linalg.inv(T_new_old)
            rospy.logwarn("[%s]: the map is expressed in %s from now on", NAME, frame)
        self._publish_poses(max(self._latest_stamp, msg.header.stamp))
        self._set_correction()
        self._keep_corrections()

    def _close_map(self, stamp, because):
        """Begins a new map, to which the present one does not relate."""
        rospy.logerr("[%s]: the map is closed: %s", NAME, because)
        self._diagnostics.set_level(NodeDiagnostics.WARN, "the map was closed: " + because)
        self._session, self._first_T_W_O = OptimizerSession(self._graph_config, self._config), np.eye(4)
        self._closed_at, self._closed_because = stamp, because

    def _take(self, msg):
        """Adds one submap. Returns True if it is new."""
        record = graph_messages.record_from_msg(msg)
        record = record._replace(T_O_S=self._origins.express(msg.header.frame_id, record.T_O_S))
        with self._diagnostics.time("add"):
            is_new = self._session.add_submap(record, graph_messages.field_from_msg(msg, record))
        self._latest_stamp = max(self._latest_stamp, msg.header.stamp)
        return is_new

    def _add_submap(self, msg):
        try:
            if self._take(msg):
                self._solve()
        finally:
            self._progress.publish(msg.header.stamp)

    def _add_loop(self, msg):
        self._session.add_loop(graph_messages.loop_from_msg(msg))
        self._solve()

    def _solve(self, full=False):
        start_s = time.monotonic()
        with self._diagnostics.time("solve"):
            report = self._session.optimize(full=full)
        self._set_correction()
        self._keep_corrections()
        self._publish(report, time.monotonic() - start_s)
        return report

    def _publish(self, report, solve_s):
        frame, stamp, session = self._config.map_frame, self._latest_stamp, self._session
        with self._diagnostics.time("publish"):
            self._publish_poses(stamp)
            self._report_out.publish(graph_messages.report_to_msg(report, session, stamp, frame, solve_s))
            self._markers_out.publish(
                graph_messages.markers_to_msg(session, stamp, frame, self._config.max_marker_lines))
            self._trajectory_out.publish(graph_messages.trajectory_to_msg(session, stamp, frame))
        self._diagnostics.set_level(NodeDiagnostics.OK)
        for name, value in (("submaps", report.num_submaps), ("pairs", report.pairs), ("cost", report.cost_after),
                            ("rejected_loops", len(report.rejected_loops)), ("revision", session.revision)):
            self._diagnostics.set_counter(name, value)
        for kind, count in session.dropped.items():
            self._diagnostics.set_counter("dropped_" + kind, count)

    def _publish_poses(self, stamp):
        msg = graph_messages.poses_to_msg(self._session, stamp, self._config.map_frame)
        msg.odometry_frame = self._origins.frame
        msg.closed_at, msg.closed_because = self._closed_at, self._closed_because
        self._progress.announce(stamp)
        self._poses_out.publish(msg)

    def _solve_and_tell(self):
        report = self._solve(full=True)
        return "%d submaps, %d pairs, cost %.1f -> %.1f" % (
            report.num_submaps, report.pairs, report.cost_before, report.cost_after)

    def _save(self, path):
        partial = path + ".part"
        with open(partial, "w") as out:
            out.write(self._session.graph.to_g2o())
        os.replace(partial, path)
        return "saved %d submaps to %s" % (len(self._session.records), path)

    def _set_kind(self, kind, is_enabled):
        self._session.graph.set_kind_enabled(kind, is_enabled)
        self._solve()
        return "%s constraints are %s" % (kind, "on" if is_enabled else "off")


def main():
    run_node(NAME, SubmapOptimizer)
