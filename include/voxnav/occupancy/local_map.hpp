// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/containers/grid_update.hpp"
#include "voxnav/geometry/aabb.hpp"
#include "voxnav/geometry/points_view.hpp"
#include "voxnav/occupancy/local_map_config.hpp"
#include "voxnav/occupancy/map_content.hpp"

namespace voxnav::occupancy {

/// What one insertion did.
struct InsertStatistics {
  std::size_t points = 0;
  std::size_t rejected_not_finite = 0;
  std::size_t rejected_too_near = 0;  ///< zero range included
  std::size_t far = 0;                ///< beyond max_range_m: no hit
  std::size_t outside_window = 0;     ///< within range but above or below the window: no hit
  std::size_t cells_hit = 0;
  std::size_t cells_missed = 0;
  std::size_t cells_occupied = 0;  ///< became occupied
  std::size_t cells_freed = 0;     ///< became free
  std::size_t cells_evicted = 0;   ///< known voxels that left the window
  std::size_t blocks_evicted = 0;
  bool window_cleared = false;  ///< the pose jumped beyond the window
};

/// Worst state (occupied, unknown, free in this order) of all voxels that a body of the given radius touches on
/// its way, and how far it gets before it touches the first one that is not known free.
struct CorridorState {
  containers::State worst = containers::State::kFree;
  std::optional<double> first_bad_m;
};

struct NearestHit {
  geometry::Vec3 point;  ///< mean hit point of the voxel
  double distance_m = 0.0;
};

struct RayCast {
  containers::State state = containers::State::kFree;  ///< of the voxel that stopped the ray; free = reached the end
  double range_m = 0.0;                                ///< to where that voxel is entered, or the whole length
};

/// Rolling three-state occupancy octree around a sensor, frame O (or any fixed frame). Each scan gives each voxel
/// at most one hit or one miss; hits win. Not thread-safe.
/// Source: Duberg and Jensfelt, UFOMap, RA-L 2020, section III, for states and inner nodes.
class LocalMap {
 public:
  /// @throws base::ConfigError
  explicit LocalMap(const LocalMapConfig& config);
  ~LocalMap();
  LocalMap(LocalMap&&) noexcept;
  LocalMap& operator=(LocalMap&&) noexcept;

  /// Moves the window to the sensor and inserts one scan.
  /// @param points_L         hits, frame L; those that are not finite are left out and counted
  /// @param T_W_L            the sensor in the frame of the map
  /// @param no_return_directions_L  directions that returned nothing (any length but zero): no_return_range_m of them
  /// is free
  /// @throws std::invalid_argument when the pose is not finite, not rigid or beyond the reach of voxel indices
  /// O(points + voxels crossed).
  InsertStatistics insert(const geometry::PointsView& points_L, const geometry::Pose& T_W_L,
                          const geometry::PointsView& no_return_directions_L = {});
  /// Voxels whose centre lies within `radius_m` become free unless they are occupied: the vehicle stands there.
  std::size_t mark_free(const geometry::Vec3& center, double radius_m);
  /// Sets voxels to log-odds from elsewhere, for example another map; those outside the window are left out. Nothing is
  /// known of hit points inside them. Returns how many were set.
  struct VoxelLogOdds {
    geometry::Vec3 point;
    double log_odds;
  };
  std::size_t assign(const std::vector<VoxelLogOdds>& voxels);
  /// Puts the window around a place where the map is still empty.
  void place_window(const geometry::Vec3& center);
  /// Everything becomes unknown; nothing is handed out.
  void clear();
  /// @throws base::ConfigError unless free < occupied and both are probabilities
  void set_thresholds(double free_threshold, double occupied_threshold);

  containers::State state(const geometry::Vec3& point) const;
  /// Log-odds of the voxel at a point; none outside the window and where no scan ever reached.
  std::optional<double> log_odds(const geometry::Vec3& point) const;
  /// Worst state of all voxels that a box touches. Unknown when any part lies outside the window.
  containers::State box_state(const geometry::Aabb& box) const;
  CorridorState corridor_state(const geometry::Vec3& a, const geometry::Vec3& b, double radius_m) const;
  /// From a towards b; stops at the first occupied voxel, and at unknown ones unless told to pass them.
  RayCast ray_cast(const geometry::Vec3& a, const geometry::Vec3& b, bool pass_unknown) const;
  std::optional<NearestHit> nearest_occupied(const geometry::Vec3& point, double max_distance_m) const;

  /// (x, y, z) rows; blocks in the order of their index, voxels in the order of theirs.
  std::vector<float> occupied_points() const;
  std::vector<float> centers_above(double probability) const;
  std::vector<float> centers_below(double probability) const;

  struct KnownVoxel {
    geometry::Index3 index;
    containers::State state;  ///< free or occupied
    double log_odds;
  };
  /// Visits every voxel that is free or occupied, in the order of the lists above.
  void for_known(const std::function<void(const KnownVoxel&)>& visit) const;

  MapContent content() const;
  /// The same, after which own hits of the content are counted anew. What is known, and what is believed, stay.
  MapContent hand_over();
  /// What left the window since the last call. Bounded by max_evicted_blocks.
  MapContent take_evicted();
  std::size_t num_evicted_pending() const;
  std::size_t num_evicted_dropped() const;
  /// Blocks whose states changed since the last call; a snapshot when nobody asked for so long that the changes were
  /// given up.
  containers::GridUpdate take_changes();
  /// Rises with every call that may change the map.
  std::uint64_t sequence() const;
  /// Blocks whose states changed after the map had the given sequence; a snapshot for 0, for a sequence this map never
  /// had, and where changes that old were given up. Any number of readers may keep a sequence each, so that none of
  /// them is ever sent what it has.
  containers::GridUpdate changes_since(std::uint64_t sequence) const;
  containers::GridUpdate snapshot() const;

  std::string to_bytes() const;
  /// @throws std::invalid_argument naming what is wrong with the bytes
  static LocalMap from_bytes(const std::string& bytes);
  /// @throws std::runtime_error when the file cannot be written or read
  void save(const std::string& path) const;
  static LocalMap load(const std::string& path);

  const LocalMapConfig& config() const;
  std::size_t memory_bytes() const;

  struct Impl;
  /// The octree itself, for tests of it; see src/core/occupancy/local_map_impl.hpp.
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace voxnav::occupancy
