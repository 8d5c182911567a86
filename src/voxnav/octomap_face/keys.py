# SPDX-License-Identifier: BSD-3-Clause
"""The keys of the configurations of MRS: which parameter of voxnav each of them becomes, or why it becomes none."""

from dataclasses import dataclass
from typing import Any, Callable, Dict, Sequence, Tuple, Union


@dataclass(frozen=True)
class Becomes:
    """The value, converted, is that of some parameters (node/section/name; SENSOR stands for the name of a sensor)."""

    targets: Tuple[str, ...]
    convert: Callable[[Any], Any] = float


@dataclass(frozen=True)
class Kept:
    """voxnav keeps to its own way. The reason is told if the value asks for another one."""

    reason: str
    usual: Sequence[Any] = ()  # values that ask for nothing else; none given: every value asks for something else

    def is_what_voxnav_does(self, value: Any) -> bool:
        return value in self.usual


Rule = Union[Becomes, Kept]
# Values of this kind change nothing that a flight depends on, and nothing is said about them.
ANY = type("Any", (), {"__contains__": lambda self, value: True})()


def becomes(*targets: str, convert: Callable[[Any], Any] = float) -> Becomes:
    return Becomes(targets, convert)


def period_s(rate_hz: Any) -> float:
    return max(0.1, 1.0 / float(rate_hz))


def scan_period_s(rate_hz: Any) -> float:
    """With the rate of scans or more every scan has its map."""
    return 0.05 if float(rate_hz) >= 10.0 else 1.0 / float(rate_hz)


def altitude_m(value: Any) -> float:
    return min(max(float(value), -1000.0), 9000.0)


def whole(value: Any) -> int:
    return int(value)


UNSEEN = "voxnav has no such rays: beams without return clear map/no_return_range_m if open_beams/is_enabled is set"
MODEL = "voxnav keeps its own sensor model (map/prob_*), by which its thresholds were chosen"
WINDOW = "voxnav keeps its window (map/window_size_m), which is also the map that its planner flies by"
SEARCH = "voxnav plans by its own rules (sections planner and manager of planning_manager)"
OWN_PLANNER = "voxnav has one planner, which stands in for both"

SERVER: Dict[str, Rule] = {
    "resolution": becomes("local_mapper/map/resolution_m", "submap_integrator/collection/resolution_m"),
    "map_while_grounded": Kept("voxnav maps on the ground, too", (True,)),
    "scope_timer/enabled": Kept("", ANY),
    "scope_timer/file_name": Kept("", ANY),
    "persistency/enabled": becomes("octomap_server/node/loads_at_start", convert=bool),
    "persistency/map_name": becomes("octomap_server/node/map_name", convert=str),
    "persistency/save_time": becomes("octomap_server/node/autosave_period_s"),
    "persistency/align_altitude/enabled": becomes("octomap_server/node/aligns_altitude", convert=bool),
    "persistency/align_altitude/ground_detection_distance": becomes("octomap_server/node/ground_distance_m"),
    "persistency/align_altitude/robot_height": becomes("octomap_server/node/robot_height_m"),
    "local_map/publisher_rate": becomes("local_mapper/node/octomap_period_s", convert=scan_period_s),
    "local_map/publish_full": Kept("it is sent while somebody subscribes", (True,)),
    "local_map/publish_binary": Kept("", ANY),
    "global_map/enabled": Kept("voxnav needs its global map", (True,)),
    "global_map/publisher_rate": becomes("submap_integrator/node/octomap_period_s", convert=period_s),
    "global_map/creation_rate": Kept("the global map is made of submaps, one each local_mapper/submap/period_s"),
    "global_map/compress": Kept("", ANY),
    "global_map/publish_full": Kept("it is sent while somebody subscribes", (True,)),
    "global_map/publish_binary": Kept("", ANY),
    "unknown_rays/update_free_space": Kept(UNSEEN),
    "unknown_rays/clear_occupied": Kept("voxnav never clears what is occupied by beams that met nothing", (False,)),
    "unknown_rays/ray_distance": Kept(UNSEEN),
    "sensor/max_range": becomes("local_mapper/SENSOR/max_range_m"),
    "sensor/free_ray_distance": Kept("voxnav clears up to the end of each beam"),
    "sensor/vertical_fov_angle": Kept("", ANY),
    "sensor/horizontal_fov_angle": Kept("", ANY),
    "sensor/vertical_rays": Kept("", ANY),
    "sensor/horizontal_rays": Kept("", ANY),
    "sensor/unknown_rays/update_free_space": Kept(UNSEEN, (False,)),
    "sensor/unknown_rays/clear_occupied": Kept("voxnav never clears what is occupied by such beams", (False,)),
    "sensor/unknown_rays/free_ray_distance_unknown": Kept(UNSEEN),
}
SERVER.update({"local_map/size/" + name: Kept(WINDOW)
               for name in ("max_width", "max_height", "min_width", "min_height")})
SERVER.update({"local_map/size/" + name: Kept("", ANY) for name in ("duty_high_threshold", "duty_low_threshold")})
SERVER.update({"sensor_model/" + name: Kept(MODEL) for name in ("hit", "miss", "min", "max")})

PLANNER: Dict[str, Rule] = {
    "safe_obstacle_distance": becomes("planning_manager/planner/safety_distance_m"),  # before MRS 1.5
    "safe_obstacle_distance/default": becomes("planning_manager/planner/safety_distance_m"),
    "safe_obstacle_distance/min": becomes("octomap_planner/node/min_safety_distance_m"),
    "safe_obstacle_distance/max": becomes("octomap_planner/node/max_safety_distance_m"),
    "main_timer/rate": becomes("planning_manager/node/main_rate_hz"),
    "future_check_timer/rate": becomes("planning_manager/node/check_rate_hz"),
    "diagnostics_timer/rate": becomes("octomap_planner/node/diagnostics_rate_hz"),
    "goal_reached_dist": becomes("planning_manager/manager/goal_tolerance_m"),
    "replan_after": becomes("planning_manager/manager/replan_interval_s"),
    "time_for_trajectory_generator": becomes("planning_manager/manager/generation_budget_s"),
    "min_altitude": becomes("planning_manager/map/min_altitude_m", convert=altitude_m),
    "max_altitude": becomes("planning_manager/map/max_altitude_m", convert=altitude_m),
    "trajectory_generator/input_trajectory_length": becomes("planning_manager/manager/max_flight_time_s"),
    "trajectory_generator/relax_heading": becomes("planning_manager/heading/is_relaxed", convert=bool),
    "trajectory_generator/heading_offset": becomes("planning_manager/heading/offset_rad"),
    "trajectory_generator/max_segment_length_heading": becomes("planning_manager/heading/look_ahead_m"),
    "trajectory_generator/use_heading": Kept("", ANY),  # both are read by heading_mode()
    "trajectory_generator/turn_in_flight_direction": Kept("", ANY),
    "use_user_heading_for_final_point": Kept("the heading of a goal is taken where a trajectory ends at it", (False,)),
    "unknown_is_occupied": Kept("voxnav flies through known free space only, whatever it plans through", (True,)),
    "planning_tree/resolution": Kept("voxnav plans at the resolution of its map"),
    "distance_transform/submap_distance": Kept("voxnav plans within map/range_m"),
    "virtual_obstacle_publishing_timer/rate": Kept("", ANY),
    "restart_planner_on_deadlock": Kept("", ANY),
    "points_scale": Kept("", ANY),
    "lines_scale": Kept("", ANY),
    "scope_timer/enable": Kept("", ANY),
    "scope_timer/duration": Kept("", ANY),
    "subt_planner/use": Kept(OWN_PLANNER, (False,)),
    "subt_planner/debug_info": Kept("", ANY),
}
PLANNER.update({name: Kept(SEARCH) for name in (
    "euclidean_distance_cutoff", "min_path_length", "min_path_heading_change", "max_attempts_to_replan",
    "min_dist_to_goal_improvement", "max_goal_dist_to_disable_replanning", "distance_penalty", "greedy_penalty",
    "max_waypoint_distance", "timeout_threshold", "collision_check_point_count",
    "min_allowed_trajectory_points_after_crop", "planner_deadlock_timeout_factor")})
PLANNER.update({"subt_planner/" + name: Kept(OWN_PLANNER) for name in (
    "apply_postprocessing", "make_path_straight", "clearing_dist", "admissibility", "apply_pruning", "pruning_dist",
    "planning_tree/bounding_box/horizontal", "planning_tree/bounding_box/vertical", "remove_obsolete_points",
    "obsolete_points_tolerance", "shortening/window_size", "shortening/distance", "postprocessing/timeout",
    "postprocessing/path_length", "postprocessing/safe_dist", "postprocessing/max_iteration",
    "postprocessing/horizontal_neighbors_only", "postprocessing/z_diff_tolerance", "postprocessing/fix_goal_point")})


def _pcl(is_used: bool, row_step: Becomes, column_step: Becomes) -> Dict[str, Rule]:
    """Returns the rules of a filter, whose range counts only if it is used."""
    unused = Kept("", ANY)
    return {
        "lidar3d/downsampling/row_step": row_step,
        "lidar3d/downsampling/col_step": column_step,
        "lidar3d/clip/range/use": unused,
        "lidar3d/clip/range/min": becomes("cloud_filter_SENSOR/filter/min_range_m") if is_used else unused,
        "lidar3d/clip/range/max": becomes("cloud_filter_SENSOR/filter/max_range_m") if is_used else unused,
        "lidar3d/frequency": unused, "lidar3d/vfov": unused, "lidar3d/name": unused,
        "lidar3d/republish": unused, "lidar3d/keep_organized": unused,
    }


PCL: Dict[str, Callable[[bool], Dict[str, Rule]]] = {
    "lidar": lambda is_used: _pcl(
        is_used, becomes("cloud_filter_SENSOR/filter/row_decimation", convert=whole),
        becomes("cloud_filter_SENSOR/filter/column_decimation", convert=whole)),
    "depth_camera": lambda is_used: _pcl(
        is_used, becomes("depth_cloud_SENSOR/depth/row_step", convert=whole),
        becomes("depth_cloud_SENSOR/depth/column_step", convert=whole)),
}
