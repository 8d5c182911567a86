# SPDX-License-Identifier: BSD-3-Clause
"""FakeFlight drives a PlanningManager: it is a vehicle that follows trajectories exactly and sees within a range."""

import numpy as np

import voxnav
from voxnav.planning_manager import Control, Generate, Generated, Plan, Publish

LIMITS = [4.0, 2.0, 2.0, 1.0, 2.0, 1.0]
RESOLUTION = 0.4
TICK_S = 0.05
HOVER_S = 1.0


class FakeFlight:
    def __init__(self, truth, origin, start, known_range_m=20.0, T_W_O=None, map_range_m=150.0, **config):
        """Places the vehicle in a world.

        truth: (nx, ny, nz) int8 states of the world; origin: its lowest corner in O; start: position in O.
        """
        self.truth = truth.copy()
        self.origin = np.asarray(origin, dtype=float)
        self.position = np.asarray(start, dtype=float)
        self.velocity = np.zeros(3)
        self.known_range_m = known_range_m
        self.known = np.zeros_like(truth)
        self.T_W_O = np.eye(4) if T_W_O is None else T_W_O
        self.map = voxnav.NavigationMap(voxnav.NavigationMapConfig(min_altitude_m=-5.0, max_altitude_m=20.0,
                                                                   range_m=map_range_m))
        self.config = voxnav.PlanningManagerConfig(**config)
        self.manager = voxnav.PlanningManager(self.config, (-5.0, 20.0), self.map.view)
        search = voxnav.FlightSearchConfig(unknown_policy="penalise", unknown_cost=2.0, safety_distance_m=0.9,
                                           clearance_distance_m=0.0, known_distance_m=0.0)
        self.planner = voxnav.PathPlanner(search.planner_config())
        self.field = voxnav.ClearanceField(search.field_config())
        self.now = 100.0
        self.flown = None  # (points, dt, begin)
        self.log, self.track = [], []
        self.fails = set()  # kinds of actions, and means of stopping, that the services refuse
        self.shift = np.zeros(3)  # how far the vehicle is from where the tracker believes it to be
        self.delay_s = 0.0  # how old the answers of the generator are
        self.broken = set()  # kinds of actions that cannot be executed
        self.silent = set()  # kinds of actions that are never answered
        self.lost = set()  # inputs that are no longer updated
        self.limits = None  # limits that the control manager tells; None: LIMITS
        self.ahead_s = {}  # how far the stamps of inputs are ahead of the time
        self.is_flying, self.is_repelling = True, False
        self.callbacks_from = self.now  # the tracker accepts goals from this time on; it refuses them while it brakes
        self.frames = ("odom", "odom")  # the frames of the map and of the vehicle
        self.sequence = 0

    def look(self):
        """Copies the true states within the range into the map."""
        axes = [self.origin[k] + (np.arange(n) + 0.5) * RESOLUTION - self.position[k]
                for k, n in enumerate(self.truth.shape)]
        near = axes[0][:, None, None] ** 2 + axes[1][:, None] ** 2 + axes[2] ** 2 < self.known_range_m ** 2
        if np.array_equal(self.known[near], self.truth[near]):
            return
        self.known[near] = self.truth[near]
        grid = voxnav.StateGrid.from_array(self.known, self.origin, RESOLUTION)
        self.sequence += 1
        assert self.map.apply_local(self.sequence, RESOLUTION, **grid.snapshot()) == voxnav.Applied.APPLIED

    def position_at(self, time_s):
        if self.flown is None:
            return self.position
        points, dt, begin = self.flown
        at = min(max((time_s - begin) / dt, 0.0), len(points) - 1.0)
        low = int(at)
        high = min(low + 1, len(points) - 1)
        return points[low] + (at - low) * (points[high] - points[low])

    def tell(self):
        m, now = self.manager, self.now
        self.map.set_vehicle(self.position)
        self.map.set_T_W_O(self.T_W_O)
        if "odometry" not in self.lost:
            m.set_vehicle(now + self.ahead_s.get("odometry", 0.0), self.position, self.velocity)
        if "tracker" not in self.lost:
            times = now + 0.01 + 0.2 * np.arange(40)
            line = np.array([self.position_at(t) for t in times])
            m.set_prediction(now + self.ahead_s.get("tracker", 0.0), list(times), line)
        if "map" not in self.lost:
            m.set_map_stamp(now + self.ahead_s.get("map", 0.0))
        if "correction" not in self.lost:
            m.set_T_W_O(now, self.T_W_O)
        is_tracking = self.flown is not None and now < self.flown[2] + self.flown[1] * (len(self.flown[0]) - 1)
        accepts_goals = self.is_flying and now >= self.callbacks_from and not self.is_repelling
        m.set_control(now, Control(self.is_flying, accepts_goals, is_tracking, self.is_repelling))
        m.set_frames(*self.frames)
        m.set_limits(now, self.limits or LIMITS)

    def step(self):
        before = self.position
        self.now += TICK_S
        self.position = self.position_at(self.now) + self.shift
        self.velocity = (self.position - before) / TICK_S
        self.track.append(self.position)
        self.tell()
        if len(self.track) % 10 == 0 and "map" not in self.lost:
            self.look()
        self.do(self.manager.tick(self.now))
        if len(self.track) % 2 == 0:
            self.do(self.manager.check(self.now))

    def fly(self, seconds, until=lambda flight: False):
        for _ in range(int(seconds / TICK_S)):
            self.step()
            if until(self):
                return True
        return False

    def do(self, actions):
        for action in actions:
            because = getattr(action, "because", None)
            self.log.append((action.name, because.sentence if because else ""))
            if action.name in self.broken:
                self.do(self.manager.failed(action, "broken for the test", self.now))
            elif action.name not in self.silent:
                self.do(self.answer(action) or [])

    def answer(self, action):
        kinds = {action.name, getattr(action, "means", None)}
        problem = "refused for the test" if kinds & self.fails else ""
        if isinstance(action, Plan):
            view = self.map.view()
            self.field.update(view)
            outcome = voxnav.run_plan_job(self.planner, self.field, self.config, view, action.start_O, action.goal_O,
                                          LIMITS)
            return self.manager.plan_done(action.job, outcome, self.now)
        if isinstance(action, Generate):
            return self.manager.generate_done(action.job, problem or self.generate(action), self.now)
        if isinstance(action, Publish):
            if not problem:
                self.follow(action.trajectory, action.stamp_s)
            return self.manager.publish_done(action.job, problem, self.now)
        if not problem and action.trajectory is not None:
            self.follow(action.trajectory, None)
        elif not problem:
            self.hover()
        return self.manager.hover_done(problem, self.now)

    def follow(self, trajectory, stamp_s):
        self.flown = (trajectory.points, trajectory.dt_s, self.now if stamp_s is None else stamp_s)

    def hover(self):
        """Stops on the spot, whoever asked for it, and refuses goals for a moment, as an MRS system does."""
        self.flown, self.callbacks_from = None, self.now + HOVER_S

    def generate(self, action):
        """Returns a trajectory as MRS does: the prediction until the start, then along the waypoints to rest."""
        points, stamp_s = [], None
        if action.start_stamp_s is not None:
            stamp_s = self.now - self.delay_s
            points = [self.position_at(t) for t in np.arange(stamp_s, action.start_stamp_s, 0.2)]
        line = [self.position if action.start_stamp_s is None else points[-1]] + list(action.waypoints_O)
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        for s in np.arange(0.0, length[-1], 0.3):
            points.append(np.array([np.interp(s, length, np.array(line)[:, k]) for k in range(3)]))
        points.append(np.asarray(line[-1]))
        return Generated(voxnav.Trajectory(np.array(points), 0.2), stamp_s)

    def count(self, kind):
        return sum(1 for entry in self.log if entry[0] == kind)

    def clearance(self):
        """Returns the smallest distance between the flown track and the centres of truly occupied voxels."""
        centers = self.origin + (np.argwhere(self.truth == 2) + 0.5) * RESOLUTION
        if len(centers) == 0:
            return np.inf
        return min(np.linalg.norm(centers - p, axis=1).min() for p in self.track)
