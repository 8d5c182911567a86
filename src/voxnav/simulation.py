# SPDX-License-Identifier: BSD-3-Clause
"""A seeded forest, and a spinning LiDAR and a depth camera in it, without ROS.

Built only where Embree is present. Frame W: z up, ground height 0 at the start point; metres.

>>> world = World("worlds/forest.yaml", seed=1)
>>> lidar = Lidar(model="os1-16", columns=512)
>>> scan = lidar.scan(world, pose(0, 0, 2), pose(0.2, 0, 2), scan_index=0)
>>> scan.points.shape[1]
4
"""

from __future__ import annotations

import os
from typing import Any, Dict, Union

import numpy as np

from voxnav import _simulation
from voxnav._simulation import (
    CLASSES,
    AvoidanceConfig,
    BumperConfig,
    DepthCameraConfig,
    EstimatorResetsConfig,
    GnssDriftConfig,
    ImuConfig,
    LidarConfig,
    RefusalsConfig,
    StateNoiseConfig,
    TrackingConfig,
    TrajectoryGeneratorConfig,
    Uav,
    UavConfig,
    UavConstraintsConfig,
    UavFaults,
    WindConfig,
    WorldConfig,
    generate_trajectory,
)
from voxnav.array_types import Array, ArrayLike

__all__ = [
    "CLASSES",
    "AvoidanceConfig",
    "BumperConfig",
    "DepthCamera",
    "DepthCameraConfig",
    "EstimatorResetsConfig",
    "GnssDriftConfig",
    "ImuConfig",
    "Lidar",
    "LidarConfig",
    "RefusalsConfig",
    "SimulatedScan",
    "StateNoiseConfig",
    "Stems",
    "TrackingConfig",
    "TrajectoryGeneratorConfig",
    "Uav",
    "UavConfig",
    "UavConstraintsConfig",
    "UavFaults",
    "WindConfig",
    "World",
    "WorldConfig",
    "generate_trajectory",
    "pose",
]

# Path of a YAML file, fields by name, or the object itself; None for the defaults.
Config = Union[None, str, "os.PathLike[str]", Dict[str, Any], WorldConfig]


def pose(x: float, y: float, z: float, yaw_rad: float = 0.0) -> Array:
    """Returns an upright pose as (4, 4) float64."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.array([[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])


def _world_config(config: Config) -> WorldConfig:
    if config is None:
        return WorldConfig()
    if isinstance(config, WorldConfig):
        return config
    if isinstance(config, dict):
        return WorldConfig.from_dict(config)
    return _simulation.load_world_config(os.fspath(config))


def _rows(points: ArrayLike, columns: int) -> Array:
    return np.ascontiguousarray(points, dtype=np.float64).reshape(-1, columns)


class Stems:
    """Trunks or poles as generated: (k, 3) ends of their axes at the ground and at the top, and (k,) radii there."""

    def __init__(self, rows: Array) -> None:
        self.ground, self.top = rows[:, 0:3], rows[:, 3:6]
        self.radius_ground_m, self.radius_top_m = rows[:, 6], rows[:, 7]

    def __len__(self) -> int:
        return len(self.ground)


class World:
    """A generated world.

    Parameters
    ----------
    config : path of a YAML file, dict, WorldConfig, or None for the defaults
    seed : the same configuration and seed give the same mesh, byte for byte
    """

    def __init__(self, config: Config = None, seed: int = 1) -> None:
        self.scene = _simulation.Scene(_world_config(config), seed)

    @property
    def config(self) -> WorldConfig:
        return self.scene.config

    @property
    def seed(self) -> int:
        return self.scene.seed

    @property
    def counts(self) -> dict[str, int]:
        """Returns how many trees, bushes, poles, rocks, walls and houses found room in the world."""
        return self.scene.counts()

    def save_ply(self, path: str | os.PathLike[str]) -> None:
        """Writes the mesh (binary PLY, a class and a colour per face, seed and parameters in the header)."""
        self.scene.save_ply(os.fspath(path))

    def mesh(self) -> tuple[Array, Array, Array]:
        """Returns vertices (n, 3) float32, triangles (m, 3) uint32, classes (m,) uint8, the vehicle included."""
        arrays = self.scene.mesh()
        return arrays["vertices"], arrays["triangles"], arrays["classes"]

    def ground_height(self, x: ArrayLike, y: ArrayLike) -> Any:
        """Returns the height of the ground, for numbers or arrays; NaN outside of the terrain."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
        heights = self.scene.ground_height(_rows(np.stack([x, y], axis=-1), 2)).reshape(x.shape)
        return float(heights) if heights.ndim == 0 else heights

    def clearance(self, points: ArrayLike, max_m: float = 100.0, stamp_s: float | None = None) -> Array:
        """Returns the unsigned distance (n,) of (n, 3) points to the nearest surface; max_m if none is closer.

        Persons and other UAVs count where they are at the time stamp_s; without one they do not.
        """
        return self.scene.clearance(_rows(points, 3), max_m, stamp_s)

    def movers(self, stamp_s: float) -> Array:
        """Returns the persons and other UAVs at a time: (n, 6) bottom x y z, radius, height, class (CLASSES)."""
        return self.scene.movers(stamp_s)

    def nearest(self, points: ArrayLike, max_m: float = 100.0) -> tuple[Array, Array]:
        """Returns distance (n,) and class (n,) uint8 of the nearest surface; NaN and 255 if none is within max_m."""
        distances, classes = self.scene.nearest(_rows(points, 3), max_m)
        return distances, classes

    def surface_distance(self, points: ArrayLike, max_m: float = 100.0) -> Array:
        """Returns the distance (n,) to the nearest surface; NaN if none is within max_m."""
        return self.nearest(points, max_m)[0]

    def cast(self, origins: ArrayLike, directions: ArrayLike,
             max_range_m: float = 200.0) -> tuple[Array, Array, Array]:
        """Casts (n, 3) rays. Returns ranges (inf = no hit), classes (255 = no hit) and cosines of incidence."""
        ranges, classes, cosines = self.scene.cast(_rows(origins, 3), _rows(directions, 3), max_range_m)
        return ranges, classes, cosines

    def trunks(self) -> Stems:
        """Returns the Stems of all trees."""
        return self._stems("trunk")

    def poles(self) -> Stems:
        """Returns the Stems of all thin poles."""
        return self._stems("pole")

    def _stems(self, name: str) -> Stems:
        rows = self.scene.stems()
        return Stems(rows[rows[:, 8] == CLASSES[name]])

    def move_vehicle(self, x: float, y: float, heading_rad: float = 0.0) -> bool:
        """Moves the vehicle; returns False if there is none, or no ground at the new place."""
        return self.scene.move_vehicle(x, y, heading_rad)

    def vehicle_pose(self) -> Array | None:
        """Returns the pose T_W_V (4, 4) of the vehicle, or None if there is none."""
        T_W_V: Array | None = self.scene.vehicle_pose()
        return T_W_V


class SimulatedScan:
    """One turn of the LiDAR; each point is in the sensor frame at its own time.

    organised (h, w, 4) float32 x y z intensity, zeros where there is no return; ranges_m (h, w);
    labels (h, w) uint8 (see CLASSES); column_times_s (w,).
    Of the returns alone: points (n, 4) float32, point_times (n,) seconds after the start, classes (n,) uint8.
    """

    def __init__(self, arrays: dict[str, Array]) -> None:
        self.organised, self.ranges_m, self.labels = arrays["points"], arrays["ranges_m"], arrays["labels"]
        self.column_times_s = arrays["column_times_ns"] * 1e-9
        is_return = self.labels != CLASSES["none"]
        self.points = self.organised[is_return]
        self.point_times = np.broadcast_to(self.column_times_s, is_return.shape)[is_return]
        self.classes = self.labels[is_return]


class DepthCamera:
    """A depth camera; takes a DepthCameraConfig, or its fields by keyword.

    config; T_B_C: (4, 4) pose of its optical frame (right, down, forward) on the body; K: (3, 3) intrinsics.
    """

    def __init__(self, config: DepthCameraConfig | None = None, seed: int = 1, **fields: Any) -> None:
        if config is not None and fields:
            raise ValueError("give either config or fields")
        self.config = DepthCameraConfig.from_dict(fields) if config is None else config
        self._model = _simulation.DepthCameraModel(self.config, seed)
        self.T_B_C, self.K = self._model.T_B_C, self._model.K

    def image(self, world: World, T_W_C: Array, index: int = 0) -> Array:
        """Takes an image: (h, w) float32 depths along the optical axis in metres, 0 where there is none."""
        pixels: Array = self._model.image(world.scene, np.ascontiguousarray(T_W_C, dtype=np.float64), index)
        return pixels


class Lidar:
    """A LiDAR; takes a LidarConfig, a dict, or the fields of LidarConfig by keyword."""

    def __init__(self, config: LidarConfig | dict[str, Any] | None = None, seed: int = 1, **fields: Any) -> None:
        if config is not None and fields:
            raise ValueError("give either config or fields")
        if isinstance(config, LidarConfig):
            self.config = config
        else:
            self.config = LidarConfig.from_dict(config if config is not None else fields)
        self._model = _simulation.LidarModel(self.config, seed)

    @property
    def sweep_s(self) -> float:
        """The duration of one turn in seconds."""
        return self._model.sweep_s

    def scan(self, world: World, T_W_L_start: Array, T_W_L_end: Array | None = None,
             scan_index: int = 0) -> SimulatedScan:
        """Simulates one turn while the sensor moves evenly from the first to the second pose, (4, 4) float64."""
        end = T_W_L_start if T_W_L_end is None else T_W_L_end
        return SimulatedScan(self._model.scan(world.scene, T_W_L_start, end, scan_index))
