// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "voxnav/base/time.hpp"
#include "voxnav_simulation/visitors.hpp"
#include "voxnav_simulation/world.hpp"

namespace voxnav_simulation {

/// The hit of a ray.
struct Hit {
  float range_m = std::numeric_limits<float>::infinity();  ///< infinite when nothing was met
  float cos_incidence = 0.0F;                              ///< 0 grazing, 1 head-on
  SurfaceClass surface_class = SurfaceClass::kTerrain;

  bool is_hit() const { return range_m < std::numeric_limits<float>::infinity(); }
};

/// The nearest surface to a point.
struct Nearest {
  double distance_m;
  SurfaceClass surface_class;
};

using voxnav::base::StampNs;

/// A world in which rays are cast, with Embree. All methods are thread-safe. While the vehicle is being moved, each
/// call sees it either at its old or at its new place.
class Scene {
 public:
  explicit Scene(World world);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  const World& world() const { return world_; }

  /// Casts `count` rays from one origin. The directions are unit vectors in W; it is fastest if neighbours in the array
  /// have similar directions, because eight rays are traced together.
  /// Persons and other UAVs are met where they are at the given time; without one there are none.
  void cast(const Vec3f& origin, const Vec3f* directions, std::size_t count, float max_range_m, Hit* hits,
            std::optional<StampNs> at_ns = std::nullopt) const;

  /// Returns the distance to the nearest surface, or `max_m` if nothing is closer. It is positive inside a trunk too.
  /// @throws std::invalid_argument when p is not finite or max_m is negative
  double clearance(const Vec3& p, double max_m, std::optional<StampNs> at_ns = std::nullopt) const;
  /// Returns the nearest surface with its class, or nothing when no surface is closer than `max_m`.
  std::optional<Nearest> nearest(const Vec3& p, double max_m, std::optional<StampNs> at_ns = std::nullopt) const;

  /// Moves the vehicle to another place on the ground.
  /// @return false if there is no vehicle, or no ground at that place
  bool move_vehicle(double x, double y, double heading_rad);
  /// Other simulated UAVs in this world, which are met like those of the world.
  Visitors& visitors() { return visitors_; }
  /// Returns the pose of the vehicle, or nothing if the world has none.
  std::optional<Pose> vehicle_pose() const;

 private:
  struct Device;
  struct Part;
  std::shared_ptr<const Part> vehicle() const;
  /// All that moves: its shape, and the middle of its bottom at a time.
  std::vector<std::pair<const Mover*, Vec3>> moving_at(StampNs at_ns) const;
  void cast_at_movers(const Vec3f& origin, const Vec3f* directions, std::size_t count, StampNs at_ns, Hit* hits) const;

  World world_;
  std::shared_ptr<Device> device_;
  std::shared_ptr<const Part> static_part_;
  Visitors visitors_;
  mutable std::mutex mutex_;  ///< guards vehicle_
  std::shared_ptr<const Part> vehicle_;
};

/// Returns the scene of a world file and seed. All callers in a process share it, so that the LiDAR and the collision
/// monitor in one nodelet manager see the same moving vehicle. The scene lives as long as a caller holds it.
std::shared_ptr<Scene> shared_scene(const std::string& world_yaml_path, std::uint64_t seed);

}  // namespace voxnav_simulation
