// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/geometry/aabb.hpp"
#include "voxnav/geometry/points_view.hpp"
#include "voxnav/occupancy/local_map_config.hpp"
#include "voxnav/occupancy/map_content.hpp"
#include "voxnav/occupancy/new_hit.hpp"

namespace voxnav::occupancy {

/// Counts of one insertion.
struct InsertStatistics {
  std::size_t points = 0;
  std::size_t rejected_not_finite = 0;
  std::size_t rejected_too_near = 0;  ///< points nearer than min_range_m, those of zero range included
  std::size_t far = 0;                ///< points beyond max_range_m, which are no hits
  std::size_t outside_window = 0;     ///< points within range but above or below the window, which are no hits
  std::size_t cells_hit = 0;
  std::size_t cells_missed = 0;
  std::size_t cells_occupied = 0;  ///< voxels that became occupied
  std::size_t cells_freed = 0;     ///< voxels that became free
  std::size_t cells_evicted = 0;   ///< known voxels that left the window
  std::size_t blocks_evicted = 0;
  std::size_t new_not_kept = 0;  ///< as in LocalMap::num_new_not_kept()
  bool window_cleared = false;   ///< the pose jumped beyond the window, so that nothing of it could be kept
};

/// The worst state (occupied, unknown, free in this order) of all voxels that a ball touches along a segment, and the
/// arc length before it touches the first voxel that is not known to be free.
struct CorridorState {
  containers::VoxelState worst = containers::VoxelState::kFree;
  std::optional<double> first_bad_m;
};

/// A ball in which the body of another vehicle may be, frame of the map.
struct BodyBall {
  geometry::Vec3 center;
  double radius_m = 0.0;
};

struct NearestHit {
  geometry::Vec3 point;  ///< mean hit point of the voxel
  double distance_m = 0.0;
};

struct RayCast {
  containers::VoxelState state =
      containers::VoxelState::kFree;  ///< state of the voxel that stopped the ray; free = none did
  double range_m = 0.0;               ///< range at which that voxel is entered, or the whole length
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
  /// @param points_L         hits, frame L; points that are not finite are left out and counted
  /// @param T_W_L            pose of the sensor in the frame of the map
  /// @param no_return_directions_L  directions of beams without return (of any length but zero), along which
  ///                         no_return_range_m is cleared
  /// @param limits           of the sensor, if they are narrower than those of the map
  /// @throws std::invalid_argument when the pose is not finite, not rigid or beyond the reach of voxel indices
  /// O(points + voxels crossed).
  InsertStatistics insert(const geometry::PointsView& points_L, const geometry::Pose& T_W_L,
                          const geometry::PointsView& no_return_directions_L = {}, const ScanLimits& limits = {});
  /// Sets where the bodies of other vehicles are, for the scans that are inserted from here on. Voxels there that a
  /// scan hits are left as they are unless they are occupied: no hit is believed, and no beam that passes frees them.
  /// They are listed in new_hits() nevertheless. @throws std::invalid_argument for a ball that is not finite
  void set_bodies(std::vector<BodyBall> bodies);
  /// The hits of the newest scan in voxels that were believed to be free, sorted by voxel. What moves shows in these.
  const std::vector<NewHit>& new_hits() const;
  /// Returns what became of a new voxel; nothing if it is none.
  std::optional<NewVoxelSight> sight_of_new(const geometry::Index3& voxel) const;
  /// Returns how many hits in free voxels came when their block had no room to remember them as new, since the map was
  /// made. What moves there may leave hits behind, which stay until beams see through them often enough.
  std::uint64_t num_new_not_kept() const;
  /// Returns how often a voxel was to be marked as moving beyond the number that is remembered, since the map was made.
  std::uint64_t num_moving_not_kept() const;
  /// Marks new voxels as those of something that moves; others are left as they are. Content that is handed over then
  /// holds what was known of these voxels before.
  void mark_moving(const std::vector<geometry::Index3>& voxels);
  /// Does so with voxels in a box that the newest scan hit as the first one, and of which nothing was known before.
  void mark_moving_in(const geometry::Aabb& box);
  /// Takes new voxels for a part of the static map from here on.
  void mark_static(const std::vector<geometry::Index3>& voxels);
  /// Takes back the hits of moving voxels that were left: a voxel through whose surface a scan saw since its last hit
  /// becomes what it was before, one that was not hit for a while unknown. A voxel that the newest scan hit outside of
  /// the boxes is static. O(moving voxels * boxes). Returns the number of voxels that were taken back.
  /// @param bodies  where moving things are now
  std::size_t take_back_moving(const std::vector<geometry::Aabb>& bodies);
  /// Marks voxels whose centre lies within `radius_m` as free unless they are occupied, because the vehicle is there.
  std::size_t mark_free(const geometry::Vec3& center, double radius_m);
  /// Sets voxels to given log-odds, for example those of another map. Voxels outside the window are left out, and no
  /// voxel gets hit statistics. Returns the number of voxels that were set.
  struct VoxelLogOdds {
    geometry::Vec3 point;
    double log_odds;
  };
  std::size_t assign(const std::vector<VoxelLogOdds>& voxels);
  /// Places the window of an empty map around a point.
  void place_window(const geometry::Vec3& center);
  /// Makes all voxels unknown. The content is discarded, and take_evicted() does not return it.
  void clear();
  /// @throws base::ConfigError unless free < occupied and both are probabilities
  void set_thresholds(double free_threshold, double occupied_threshold);

  containers::VoxelState state(const geometry::Vec3& point) const;
  /// Returns the log-odds of the voxel at a point; nothing outside the window and in blocks that no scan ever reached.
  std::optional<double> log_odds(const geometry::Vec3& point) const;
  /// Returns the worst state of all voxels that a box touches. What lies outside the window counts as unknown.
  containers::VoxelState box_state(const geometry::Aabb& box) const;
  CorridorState corridor_state(const geometry::Vec3& a, const geometry::Vec3& b, double radius_m) const;
  /// Casts a ray from a to b, which stops at the first occupied voxel, and at unknown ones unless `pass_unknown` is
  /// set.
  RayCast ray_cast(const geometry::Vec3& a, const geometry::Vec3& b, bool pass_unknown) const;
  std::optional<NearestHit> nearest_occupied(const geometry::Vec3& point, double max_distance_m) const;

  /// The lists have rows of x, y, z, ordered by the index of the block and then by the offset of the voxel in it.
  std::vector<float> occupied_points() const;
  std::vector<float> centers_above(double probability) const;
  std::vector<float> centers_below(double probability) const;

  struct KnownVoxel {
    geometry::Index3 index;
    containers::VoxelState state;  ///< free or occupied
    double log_odds;
  };
  /// Visits every voxel that is free or occupied, in the order of the lists above.
  void for_known(const std::function<void(const KnownVoxel&)>& visit) const;

  MapContent content() const;
  /// Returns content() and begins a new submap: observations are counted from here on, and all earlier ones count as
  /// remembered. The states and surface points of the map itself do not change.
  MapContent hand_over();
  /// Returns the content that left the window since the last call, at most max_evicted_blocks blocks.
  MapContent take_evicted();
  std::size_t num_evicted_pending() const;
  std::size_t num_evicted_dropped() const;
  /// Returns the blocks whose states changed since the last call; a snapshot if the last call is so long ago that the
  /// record of removed blocks does not reach back to it.
  containers::GridUpdate take_changes();
  /// The sequence number of the map, which rises with every call that may change it.
  std::uint64_t sequence() const;
  /// Returns the blocks whose states changed after the map had the given sequence number. It is a snapshot for 0, for a
  /// number that this map never had, and if the record of removed blocks does not reach back so far. Any number of
  /// readers may each keep the sequence number of their last update, so that none of them is sent what it already has.
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
