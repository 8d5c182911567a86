# SPDX-License-Identifier: BSD-3-Clause
# Made by scripts/dev/make_stubs; do not edit.
import enum
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Sequence, Set, Tuple, overload

from voxnav.array_types import Array

class AvoidanceConfig:
    is_enabled: bool
    interval_s: float
    duration_s: float
    correction_m: float
    speed_ratio: float
    descent_mps: float
    headroom_m: float
    def __init__(
        self, *,
        is_enabled: bool = ..., interval_s: float = ..., duration_s: float = ..., correction_m: float = ...,
        speed_ratio: float = ..., descent_mps: float = ..., headroom_m: float = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> AvoidanceConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class BeamModel(str, enum.Enum):
    OS0_128 = "os0-128"
    OS0_64 = "os0-64"
    OS0_32 = "os0-32"
    OS1_16 = "os1-16"
    OS1_64 = "os1-64"
    VLP_16 = "vlp-16"
    CUSTOM = "custom"

class BumperConfig:
    is_enabled: bool
    heeds_sectors: bool
    min_distance_m: float
    overshoot_m: float
    is_derived_from_dynamics: bool
    num_sectors: int
    vertical_fov_rad: float
    def __init__(
        self, *,
        is_enabled: bool = ..., heeds_sectors: bool = ..., min_distance_m: float = ..., overshoot_m: float = ...,
        is_derived_from_dynamics: bool = ..., num_sectors: int = ..., vertical_fov_rad: float = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> BumperConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

CLASSES: Dict[Any, Any]

class ConstraintSet(str, enum.Enum):
    SLOW = "slow"
    MEDIUM = "medium"
    FAST = "fast"

class DepthCameraConfig:
    width: int
    height: int
    horizontal_fov_rad: float
    vertical_fov_rad: float
    rate_hz: float
    min_range_m: float
    max_range_m: float
    noise_per_m: float
    dropout_ratio: float
    mount_position_m: Sequence[float]
    mount_rpy_rad: Sequence[float]
    def __init__(
        self, *,
        width: int = ..., height: int = ..., horizontal_fov_rad: float = ..., vertical_fov_rad: float = ...,
        rate_hz: float = ..., min_range_m: float = ..., max_range_m: float = ..., noise_per_m: float = ...,
        dropout_ratio: float = ..., mount_position_m: Sequence[float] = ..., mount_rpy_rad: Sequence[float] = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> DepthCameraConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class DepthCameraModel:
    def __init__(self, config: DepthCameraConfig, seed: int) -> None: ...
    def image(self, scene: Scene, T_W_C: Array, index: int) -> Array: ...
    @property
    def config(self) -> DepthCameraConfig: ...
    @property
    def T_B_C(self) -> Array: ...
    @property
    def K(self) -> Array: ...

class DriverLayout(str, enum.Enum):
    OUSTER = "ouster"
    GAZEBO = "gazebo"

class EstimatorResetsConfig:
    is_enabled: bool
    interval_s: float
    jump_m: float
    def __init__(
        self, *,
        is_enabled: bool = ..., interval_s: float = ..., jump_m: float = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> EstimatorResetsConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class GnssDriftConfig:
    bound_m: float
    walk_m: float
    smoothing_s: float
    heading_bound_rad: float
    heading_walk_rad: float
    def __init__(
        self, *,
        bound_m: float = ..., walk_m: float = ..., smoothing_s: float = ..., heading_bound_rad: float = ...,
        heading_walk_rad: float = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> GnssDriftConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class ImuConfig:
    gyro_noise: float
    accel_noise: float
    gyro_bias: float
    accel_bias: float
    gyro_bias_walk: float
    accel_bias_walk: float
    def __init__(
        self, *,
        gyro_noise: float = ..., accel_noise: float = ..., gyro_bias: float = ..., accel_bias: float = ...,
        gyro_bias_walk: float = ..., accel_bias_walk: float = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> ImuConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class LidarConfig:
    model: str
    beam_elevations_rad: Sequence[Any]
    columns: int
    rate_hz: float
    min_range_m: float
    max_range_m: float
    range_noise_m: float
    dropout_ratio: float
    signal_scale: float
    signal_saturation: float
    signal_noise_ratio: float
    min_signal: float
    beam_divergence_rad: float
    footprint_rays: int
    echo_separation_m: float
    rain_mm_per_h: float
    speckle_ratio: float
    speckle_max_range_m: float
    ghost_ratio: float
    ghost_max_range_m: float
    ghost_intensity_max: float
    sun_azimuth_rad: float
    sun_elevation_rad: float
    sun_half_angle_rad: float
    mount_position_m: Sequence[float]
    mount_rpy_rad: Sequence[float]
    body_capsules_m: Sequence[float]
    body_reflectance: float
    num_threads: int
    def __init__(
        self, *,
        model: str = ..., beam_elevations_rad: Sequence[Any] = ..., columns: int = ..., rate_hz: float = ...,
        min_range_m: float = ..., max_range_m: float = ..., range_noise_m: float = ..., dropout_ratio: float = ...,
        signal_scale: float = ..., signal_saturation: float = ..., signal_noise_ratio: float = ...,
        min_signal: float = ..., beam_divergence_rad: float = ..., footprint_rays: int = ...,
        echo_separation_m: float = ..., rain_mm_per_h: float = ..., speckle_ratio: float = ...,
        speckle_max_range_m: float = ..., ghost_ratio: float = ..., ghost_max_range_m: float = ...,
        ghost_intensity_max: float = ..., sun_azimuth_rad: float = ..., sun_elevation_rad: float = ...,
        sun_half_angle_rad: float = ..., mount_position_m: Sequence[float] = ...,
        mount_rpy_rad: Sequence[float] = ..., body_capsules_m: Sequence[float] = ..., body_reflectance: float = ...,
        num_threads: int = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> LidarConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class LidarModel:
    def __init__(self, config: LidarConfig, seed: int) -> None: ...
    def scan(self, scene: Scene, T_W_L_start: Array, T_W_L_end: Array, scan_index: int) -> Dict[Any, Any]: ...
    @property
    def config(self) -> LidarConfig: ...
    @property
    def sweep_s(self) -> float: ...

class LidarSimulatorConfig:
    world_yaml: str
    seed: int
    layout: str
    sensor_frame_id: str
    body_frame_id: str
    max_marker_triangles: int
    loss_ratio: float
    other_uavs: Sequence[Any]
    waiting_nodes: Sequence[Any]
    acting_nodes: Sequence[Any]
    def __init__(
        self, *,
        world_yaml: str = ..., seed: int = ..., layout: str = ..., sensor_frame_id: str = ...,
        body_frame_id: str = ..., max_marker_triangles: int = ..., loss_ratio: float = ...,
        other_uavs: Sequence[Any] = ..., waiting_nodes: Sequence[Any] = ..., acting_nodes: Sequence[Any] = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> LidarSimulatorConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class RefusalsConfig:
    is_enabled: bool
    def __init__(
        self, *,
        is_enabled: bool = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> RefusalsConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class Scene:
    def __init__(self, config: WorldConfig, seed: int) -> None: ...
    def save_ply(self, path: str) -> None: ...
    def ground_height(self, points: Array) -> Array: ...
    def clearance(self, points: Array, max_m: float, stamp_s: Optional[float] = ...) -> Array: ...
    def movers(self, stamp_s: float) -> Array: ...
    def nearest(self, points: Array, max_m: float) -> Tuple[Any, ...]: ...
    def cast(self, origins: Array, directions: Array, max_range_m: float) -> Tuple[Any, ...]: ...
    def move_vehicle(self, x: float, y: float, heading_rad: float) -> bool: ...
    def vehicle_pose(self) -> Any: ...
    def mesh(self) -> Dict[Any, Any]: ...
    def stems(self) -> Array: ...
    def counts(self) -> Dict[Any, Any]: ...
    @property
    def config(self) -> WorldConfig: ...
    @property
    def seed(self) -> int: ...

class StateNoiseConfig:
    is_enabled: bool
    position_m: float
    velocity_mps: float
    time_s: float
    def __init__(
        self, *,
        is_enabled: bool = ..., position_m: float = ..., velocity_mps: float = ..., time_s: float = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> StateNoiseConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class TrackingConfig:
    is_enabled: bool
    horizontal_position_gain: float
    horizontal_velocity_gain: float
    vertical_position_gain: float
    vertical_velocity_gain: float
    disturbance_gain: float
    tilt_time_s: float
    thrust_time_s: float
    delay_s: float
    drag: float
    def __init__(
        self, *,
        is_enabled: bool = ..., horizontal_position_gain: float = ..., horizontal_velocity_gain: float = ...,
        vertical_position_gain: float = ..., vertical_velocity_gain: float = ..., disturbance_gain: float = ...,
        tilt_time_s: float = ..., thrust_time_s: float = ..., delay_s: float = ..., drag: float = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> TrackingConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class TrajectoryGeneratorConfig:
    sampling_s: float
    default_deviation_m: float
    limit_ratio: float
    max_waypoints: int
    max_duration_s: float
    max_iterations: int
    def __init__(
        self, *,
        sampling_s: float = ..., default_deviation_m: float = ..., limit_ratio: float = ..., max_waypoints: int = ...,
        max_duration_s: float = ..., max_iterations: int = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> TrajectoryGeneratorConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class Uav:
    def __init__(self, config: UavConfig = ..., seed: int = ..., drift: GnssDriftConfig = ..., imu: ImuConfig = ..., constraints: str = ..., scene: Optional[Scene] = ..., faults: UavFaults = ...) -> None: ...
    def step(self, duration_s: float) -> Array: ...
    def take_off(self) -> None: ...
    def land(self) -> None: ...
    def hover(self) -> None: ...
    def go_to(self, position: Any, heading_rad: float) -> None: ...
    def set_trajectory(self, points: Array, dt_s: float = ..., use_heading: bool = ...) -> None: ...
    def fly_through(self, waypoints: Array, max_deviation_m: float = ...) -> Array: ...
    def set_constraints(self, name: str) -> None: ...
    @property
    def stamp_s(self) -> float: ...
    @property
    def phase(self) -> str: ...
    @property
    def truth(self) -> Array: ...
    @property
    def estimate(self) -> Array: ...
    @property
    def velocity(self) -> Array: ...
    @property
    def drift(self) -> Array: ...
    @property
    def estimator_iteration(self) -> int: ...
    @property
    def is_repelled(self) -> bool: ...
    @property
    def is_avoiding(self) -> bool: ...
    @property
    def has_goal(self) -> bool: ...
    @property
    def height_m(self) -> Optional[float]: ...
    def prediction(self) -> Array: ...

class UavConfig:
    start_m: Sequence[float]
    start_heading_rad: float
    standing_height_m: float
    take_off_height_m: float
    rangefinder_max_m: float
    rangefinder_noise_m: float
    def __init__(
        self, *,
        start_m: Sequence[float] = ..., start_heading_rad: float = ..., standing_height_m: float = ...,
        take_off_height_m: float = ..., rangefinder_max_m: float = ..., rangefinder_noise_m: float = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> UavConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class UavConstraintsConfig:
    initial: str
    max_speed_mps: float
    slow_horizontal: Sequence[float]
    slow_vertical: Sequence[float]
    slow_heading: Sequence[float]
    medium_horizontal: Sequence[float]
    medium_vertical: Sequence[float]
    medium_heading: Sequence[float]
    fast_horizontal: Sequence[float]
    fast_vertical: Sequence[float]
    fast_heading: Sequence[float]
    def __init__(
        self, *,
        initial: str = ..., max_speed_mps: float = ..., slow_horizontal: Sequence[float] = ...,
        slow_vertical: Sequence[float] = ..., slow_heading: Sequence[float] = ...,
        medium_horizontal: Sequence[float] = ..., medium_vertical: Sequence[float] = ...,
        medium_heading: Sequence[float] = ..., fast_horizontal: Sequence[float] = ...,
        fast_vertical: Sequence[float] = ..., fast_heading: Sequence[float] = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> UavConstraintsConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class UavFaults:
    def __init__(self) -> None: ...
    @property
    def tracking(self) -> TrackingConfig: ...
    @tracking.setter
    def tracking(self, value: TrackingConfig) -> None: ...
    @property
    def wind(self) -> WindConfig: ...
    @wind.setter
    def wind(self, value: WindConfig) -> None: ...
    @property
    def state_noise(self) -> StateNoiseConfig: ...
    @state_noise.setter
    def state_noise(self, value: StateNoiseConfig) -> None: ...
    @property
    def refusals(self) -> RefusalsConfig: ...
    @refusals.setter
    def refusals(self, value: RefusalsConfig) -> None: ...
    @property
    def avoidance(self) -> AvoidanceConfig: ...
    @avoidance.setter
    def avoidance(self, value: AvoidanceConfig) -> None: ...
    @property
    def bumper(self) -> BumperConfig: ...
    @bumper.setter
    def bumper(self, value: BumperConfig) -> None: ...
    @property
    def resets(self) -> EstimatorResetsConfig: ...
    @resets.setter
    def resets(self, value: EstimatorResetsConfig) -> None: ...

class WindConfig:
    is_enabled: bool
    mean_mps: Sequence[float]
    gust_mps: float
    vertical_gust_mps: float
    gust_time_s: float
    def __init__(
        self, *,
        is_enabled: bool = ..., mean_mps: Sequence[float] = ..., gust_mps: float = ...,
        vertical_gust_mps: float = ..., gust_time_s: float = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> WindConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

class WorldConfig:
    min_corner_m: Sequence[float]
    size_m: Sequence[float]
    start_m: Sequence[float]
    goal_m: Sequence[float]
    clear_radius_m: float
    terrain_margin_m: float
    terrain_cell_m: float
    terrain_amplitude_m: float
    terrain_wavelength_m: float
    terrain_roughness_m: float
    trees_per_ha: float
    tree_spacing_m: float
    trunk_radius_min_m: float
    trunk_radius_max_m: float
    trunk_lean_max_rad: float
    conifer_ratio: float
    crown_base_min_m: float
    crown_base_max_m: float
    crown_radius_max_m: float
    branches_per_tree: int
    low_branch_ratio: float
    leaves_per_tree: int
    leaf_size_m: float
    twigs_per_tree: int
    twig_radius_m: float
    bushes_per_ha: float
    bush_radius_max_m: float
    leaves_per_bush: int
    num_poles: int
    pole_radius_min_m: float
    pole_radius_max_m: float
    pole_height_m: float
    rocks_per_ha: float
    rock_radius_max_m: float
    num_walls: int
    wall_length_m: float
    wall_height_m: float
    num_houses: int
    has_vehicle: bool
    vehicle_position_m: Sequence[float]
    vehicle_heading_rad: float
    num_walkers: int
    walker_speed_mps: float
    walker_waypoints: Sequence[Any]
    num_flyers: int
    flyer_speed_mps: float
    flyer_waypoints: Sequence[Any]
    def __init__(
        self, *,
        min_corner_m: Sequence[float] = ..., size_m: Sequence[float] = ..., start_m: Sequence[float] = ...,
        goal_m: Sequence[float] = ..., clear_radius_m: float = ..., terrain_margin_m: float = ...,
        terrain_cell_m: float = ..., terrain_amplitude_m: float = ..., terrain_wavelength_m: float = ...,
        terrain_roughness_m: float = ..., trees_per_ha: float = ..., tree_spacing_m: float = ...,
        trunk_radius_min_m: float = ..., trunk_radius_max_m: float = ..., trunk_lean_max_rad: float = ...,
        conifer_ratio: float = ..., crown_base_min_m: float = ..., crown_base_max_m: float = ...,
        crown_radius_max_m: float = ..., branches_per_tree: int = ..., low_branch_ratio: float = ...,
        leaves_per_tree: int = ..., leaf_size_m: float = ..., twigs_per_tree: int = ..., twig_radius_m: float = ...,
        bushes_per_ha: float = ..., bush_radius_max_m: float = ..., leaves_per_bush: int = ..., num_poles: int = ...,
        pole_radius_min_m: float = ..., pole_radius_max_m: float = ..., pole_height_m: float = ...,
        rocks_per_ha: float = ..., rock_radius_max_m: float = ..., num_walls: int = ..., wall_length_m: float = ...,
        wall_height_m: float = ..., num_houses: int = ..., has_vehicle: bool = ...,
        vehicle_position_m: Sequence[float] = ..., vehicle_heading_rad: float = ..., num_walkers: int = ...,
        walker_speed_mps: float = ..., walker_waypoints: Sequence[Any] = ..., num_flyers: int = ...,
        flyer_speed_mps: float = ..., flyer_waypoints: Sequence[Any] = ...
    ) -> None: ...
    @staticmethod
    def from_dict(values: Dict[Any, Any]) -> WorldConfig: ...
    def to_dict(self) -> Dict[Any, Any]: ...
    @staticmethod
    def describe() -> List[Any]: ...

def generate_trajectory(waypoints: Array, constraints: str = ..., max_deviation_m: float = ..., stop_at_waypoints: bool = ..., sampling_s: float = ...) -> Dict[Any, Any]: ...

def load_world_config(path: str) -> WorldConfig: ...
