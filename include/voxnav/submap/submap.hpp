// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "voxnav/geometry/distance_field.hpp"
#include "voxnav/occupancy/map_content.hpp"
#include "voxnav/submap/submap_config.hpp"

namespace voxnav::submap {

class DistanceBlock;
class DistanceCache;
class SubmapContent;

/// A finished piece of the global map: distances, states and surface points. Frozen, so thread-safe.
/// Its grid G is the grid it was measured in (the local map's, axis-aligned in O); T_S_G ties it to the
/// submap frame S, so nothing is ever resampled.
class Submap final : public geometry::DistanceField {
 public:
  /// Occupancy filling. @param T_S_G frame of the content's grid in the submap frame (T_O_S inverse)
  /// @throws std::invalid_argument on inconsistent content, base::ConfigError on a bad configuration
  static std::shared_ptr<Submap> from_content(const occupancy::MapContent& content, const geometry::Pose& T_S_G,
                                              const SubmapConfig& config);
  ~Submap() override;
  Submap(const Submap&) = delete;
  Submap& operator=(const Submap&) = delete;

  /// A point is observed when the voxel it lies in is known. Where all eight voxels around it have stored distances
  /// (near surfaces) they are interpolated trilinearly and the gradient is that of the interpolation; elsewhere the
  /// nearest surface point is searched, exactly, up to max_distance_m. Certified submaps return the exact distance to
  /// the nearest occupied voxel as a cube (at most 0 inside one), which nothing occupied can be nearer than.
  /// Distances near surfaces are derived block by block when they are first asked for, and cached within a limit.
  /// @complexity near surfaces O(1) while their block is cached, else O(blocks within reach)
  /// @throws std::runtime_error when the submap was moved to disk and cannot be read back
  bool sample(const geometry::Vec3& p_S, double* distance_m, geometry::Vec3* gradient) const override;
  /// Points that registration takes, derived when first asked for.
  const std::vector<geometry::SurfacePoint>& surface_points() const override;
  geometry::Aabb surface_bounds() const override;
  double resolution_m() const override { return resolution_m_; }

  containers::State state(const geometry::Vec3& p_S) const;
  /// The surface point of every occupied voxel [m, frame S]; none is left out.
  std::vector<geometry::Vec3f> occupied_points() const;
  /// Box around everything known [m, frame S].
  geometry::Aabb known_bounds() const { return known_bounds_; }
  const geometry::Pose& T_S_G() const { return T_S_G_; }
  const SubmapConfig& config() const { return config_; }
  /// What the submap holds in memory itself; cached distances are not counted (set_distance_cache_bytes()).
  std::size_t memory_bytes() const;

  /// Moves the content to a file, which belongs to the submap from then on and is removed with it. Answers stay the
  /// same. @throws std::runtime_error when it cannot be written (the content then stays in memory)
  void page_out(const std::string& path) const;
  bool is_resident() const { return std::atomic_load(&content_) != nullptr; }

  /// Versioned little-endian form with a checksum.
  std::string to_bytes() const;
  /// @throws std::invalid_argument naming what is wrong with the bytes
  static std::shared_ptr<Submap> from_bytes(const std::string& bytes);

  /// How much of the distances near surfaces all submaps of this process keep at hand together. What does not fit is
  /// derived again when it is asked for; answers stay the same.
  static void set_distance_cache_bytes(std::size_t bytes);

  // What follows is for the parts of this floor: SubmapContent is no public type.

  /// From content that was packed before. @throws std::invalid_argument on a bad frame
  static std::shared_ptr<Submap> from_packed(SubmapContent content, double resolution_m, const geometry::Pose& T_S_G,
                                             const SubmapConfig& config);
  /// Takes surface points that were measured in place of those that follow from the content.
  void set_surface_points(std::vector<geometry::SurfacePoint> points);
  /// What it is made of; read back from disk when it was moved there. Hold it while it is used.
  std::shared_ptr<const SubmapContent> content() const;
  /// sample() for who holds its content() already, which takes a lock.
  bool sample_in(const SubmapContent& content, const geometry::Vec3& p_S, double* distance_m,
                 geometry::Vec3* gradient) const;
  /// For each occupied voxel whether it belongs to something thin (find_thin()); found once.
  const std::vector<bool>& thin_voxels() const;
  /// Distances of the block at a position of the content.
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
  mutable std::mutex mutex_;                              ///< of what follows
  mutable std::unique_ptr<Surface> surface_;              ///< set once
  mutable std::unique_ptr<std::vector<bool>> thin_;       ///< set once
  mutable std::string page_path_;                         ///< empty = never moved to disk
};

}  // namespace voxnav::submap
