// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "voxnav/geometry/distance_field.hpp"
#include "voxnav/occupancy/map_content.hpp"
#include "voxnav/submap/compressed_field.hpp"
#include "voxnav/submap/submap_config.hpp"

namespace voxnav::submap {

/// A finished piece of the global map: distances, states and surface points. Frozen, so thread-safe.
/// Its grid G is the grid it was measured in (the local map's, axis-aligned in O); T_S_G ties it to the
/// submap frame S, so nothing is ever resampled.
class Submap final : public geometry::DistanceField {
 public:
  /// Occupancy filling. @param T_S_G frame of the content's grid in the submap frame (T_O_S inverse)
  /// @throws std::invalid_argument on inconsistent content, base::ConfigError on a bad configuration
  static std::shared_ptr<Submap> from_content(const occupancy::MapContent& content, const geometry::Pose& T_S_G,
                                              const SubmapConfig& config);
  /// From blocks that some filling made; sorted by index.
  Submap(const std::vector<FilledBlock>& blocks, double resolution_m, const geometry::Pose& T_S_G,
         const SubmapConfig& config);

  /// A point is observed when the voxel it lies in is known. Where all eight voxels around it have stored distances
  /// (near surfaces) they are interpolated trilinearly and the gradient is that of the interpolation; elsewhere the
  /// nearest surface point is searched, exactly, up to max_distance_m. Certified submaps return the exact distance to
  /// the nearest occupied voxel as a cube (at most 0 inside one), which nothing occupied can be nearer than.
  /// @complexity near surfaces O(1), else O(blocks within reach)
  bool sample(const geometry::Vec3& p_S, double* distance_m, geometry::Vec3* gradient) const override;
  const std::vector<geometry::SurfacePoint>& surface_points() const override { return surface_points_; }
  geometry::Aabb surface_bounds() const override { return surface_bounds_; }
  double resolution_m() const override { return resolution_m_; }

  containers::State state(const geometry::Vec3& p_S) const;
  /// Surface point of every occupied voxel, frame S; none is left out.
  std::vector<geometry::Vec3f> occupied_points() const;
  /// Box around everything known, frame S.
  geometry::Aabb known_bounds() const { return known_bounds_; }
  const CompressedField& field() const { return field_; }
  const geometry::Pose& T_S_G() const { return T_S_G_; }
  const SubmapConfig& config() const { return config_; }
  std::size_t memory_bytes() const;

  /// Versioned little-endian form with a checksum.
  std::string to_bytes() const;
  /// @throws std::invalid_argument naming what is wrong with the bytes
  static std::shared_ptr<Submap> from_bytes(const std::string& bytes);

 private:
  Submap() = default;
  void update_bounds();
  bool sample_near(const geometry::Vec3& p, double* distance, geometry::Vec3* gradient) const;
  void sample_far(const geometry::Vec3& p, CompressedField::Target target, double* distance,
                  geometry::Vec3* gradient) const;
  void sample_certified(const geometry::Vec3& p, double* distance, geometry::Vec3* gradient) const;

  double resolution_m_ = 0.0;
  SubmapConfig config_;
  geometry::Pose T_S_G_ = geometry::Pose::Identity();
  geometry::Pose T_G_S_ = geometry::Pose::Identity();
  CompressedField field_;
  std::vector<geometry::SurfacePoint> surface_points_;
  geometry::Aabb surface_bounds_;
  geometry::Aabb known_bounds_;
};

}  // namespace voxnav::submap
