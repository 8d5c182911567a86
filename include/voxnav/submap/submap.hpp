// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "voxnav/geometry/distance_field.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/occupancy/map_content.hpp"
#include "voxnav/submap/submap_config.hpp"

namespace voxnav::submap {

class DistanceBlock;
class DistanceCache;
class SubmapContent;

/// A finished submap: states, surface points and distances. Immutable, hence thread-safe. It keeps the grid G in which
/// it was measured (that of the local map, axis-aligned in O), and T_S_G relates the grid to the submap frame S, so
/// that nothing is ever resampled.
class Submap final : public geometry::DistanceField {
 public:
  /// Makes a submap of the content of a local map.
  /// @param T_S_G  frame of the content's grid in the submap frame (the inverse of T_O_S)
  /// @throws std::invalid_argument on inconsistent content, base::ConfigError on a bad configuration
  static std::shared_ptr<Submap> from_content(const occupancy::MapContent& content, const geometry::Pose& T_S_G,
                                              const SubmapConfig& config);
  ~Submap() override;
  Submap(const Submap&) = delete;
  Submap& operator=(const Submap&) = delete;

  /// Returns the signed distance and its gradient at a point, which must lie in a known voxel. If all eight voxels
  /// around it have distances (near surfaces), these are interpolated trilinearly and the gradient is that of the
  /// interpolation; elsewhere the nearest surface point is searched, exactly, up to max_distance_m. Certified submaps
  /// return the exact distance to the nearest occupied voxel as a cube (at most 0 inside one), a lower bound of the
  /// distance to everything in occupied voxels.
  /// Distances near surfaces are derived block by block when they are first asked for, and cached within a limit.
  /// @complexity near surfaces O(1) while their block is cached, else O(blocks within reach)
  /// @throws std::runtime_error if the submap was moved to disk and cannot be read back
  bool sample(const geometry::Vec3& p_S, double* distance_m, geometry::Vec3* gradient) const override;
  /// The surface points for registration, derived when first asked for.
  const std::vector<geometry::SurfacePoint>& surface_points() const override;
  geometry::Aabb surface_bounds() const override;
  double resolution_m() const override { return resolution_m_; }

  containers::VoxelState state(const geometry::Vec3& p_S) const;
  /// The surface points of all occupied voxels [m, frame S].
  std::vector<geometry::Vec3f> occupied_points() const;
  /// The bounding box of all known voxels [m, frame S].
  geometry::Aabb known_bounds() const { return known_bounds_; }
  const geometry::Pose& T_S_G() const { return T_S_G_; }
  const SubmapConfig& config() const { return config_; }
  /// The memory of the submap itself; cached distances are not counted (see set_distance_cache_bytes()).
  std::size_t memory_bytes() const;

  /// Moves the content to a file, which belongs to the submap from then on and is removed with it. Queries still give
  /// the same results. @throws std::runtime_error if the file cannot be written (the content then stays in memory)
  void page_out(const std::string& path) const;
  bool is_resident() const { return std::atomic_load(&content_) != nullptr; }

  /// Serialises the submap, little-endian, with a version and a checksum (docs/map_format.md).
  std::string to_bytes() const;
  /// @throws std::invalid_argument naming what is wrong with the bytes
  static std::shared_ptr<Submap> from_bytes(const std::string& bytes);

  /// Sets the size of the cache of distances near surfaces that all submaps of this process share. Distances that do
  /// not fit are derived again when they are asked for; queries give the same results.
  static void set_distance_cache_bytes(std::size_t bytes);

  // The functions from here on are for the sources of this floor only: SubmapContent is no public type.

  /// Makes a submap of packed content. @throws std::invalid_argument on a bad frame
  static std::shared_ptr<Submap> from_packed(SubmapContent content, double resolution_m, const geometry::Pose& T_S_G,
                                             const SubmapConfig& config);
  /// Sets measured surface points, which replace those that follow from the content.
  void set_surface_points(std::vector<geometry::SurfacePoint> points);
  /// Returns the content, which is read back if it was moved to disk. The caller holds the pointer while it uses it.
  std::shared_ptr<const SubmapContent> content() const;
  /// sample() for callers that already hold content(), which takes a lock.
  bool sample_in(const SubmapContent& content, const geometry::Vec3& p_S, double* distance_m,
                 geometry::Vec3* gradient) const;
  /// Returns for each occupied voxel whether it belongs to a thin thing (find_thin()); computed once.
  const std::vector<bool>& thin_voxels() const;
  /// Returns the distances of the block at a position of the content.
  std::shared_ptr<const DistanceBlock> distances(const SubmapContent& content, std::size_t position) const;

 private:
  Submap();
  struct Surface {
    std::vector<geometry::SurfacePoint> points;
    geometry::Aabb bounds;
  };
  void take_content(SubmapContent content);
  const Surface& surface() const;
  bool sample_near(const SubmapContent& content, std::size_t position, const geometry::Vec3& p, double* distance,
                   geometry::Vec3* gradient) const;
  void sample_far(const SubmapContent& content, const geometry::Vec3& p, double* distance,
                  geometry::Vec3* gradient) const;
  void sample_certified(const SubmapContent& content, std::size_t position, const geometry::Vec3& p, double* distance,
                        geometry::Vec3* gradient) const;

  double resolution_m_ = 0.0;
  SubmapConfig config_;
  geometry::Pose T_S_G_ = geometry::Pose::Identity();
  geometry::Pose T_G_S_ = geometry::Pose::Identity();
  geometry::Aabb known_bounds_;
  std::unique_ptr<DistanceCache> cache_;
  mutable std::shared_ptr<const SubmapContent> content_;  ///< accessed atomically; null = on disk
  mutable std::mutex mutex_;                              ///< protects the members below
  mutable std::unique_ptr<Surface> surface_;              ///< set once
  mutable std::unique_ptr<std::vector<bool>> thin_;       ///< set once
  mutable std::string page_path_;                         ///< empty = never moved to disk
};

/// Returns the distance field by which a submap is registered to others. It holds the distances to the surface points
/// that the submap observed, without what its local map remembered: two submaps that inherit the same content fit each
/// other wherever odometry put them. It is defined only within the band around these surfaces. A submap whose distances
/// were measured by rays is its own field, as it remembers nothing. Immutable; thread-safe. O(size of the submap).
/// @param T_S_B  poses of the sensor during the submap, by rising stamps. With them, things that are seen from one side
///               (trunks, branches) are registered by their middles, without them by the side that was hit
std::shared_ptr<const geometry::DistanceField> registration_field(const std::shared_ptr<const Submap>& submap,
                                                                  const std::vector<geometry::StampedPose>& T_S_B = {});

}  // namespace voxnav::submap
