// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "containers/number_table.hpp"
#include "submap/distance/surface_normals.hpp"
#include "voxnav/submap/projective_integrator.hpp"

namespace voxnav::submap {

/// The voxels of a TSDF into which ProjectiveIntegrator fuses scans.
class ProjectiveIntegrator::Volume {
 public:
  explicit Volume(const ProjectiveConfig& config) : config_(base::checked(config)) {}

  Counts integrate(const std::vector<geometry::Vec3f>& points_L, const geometry::Pose& T_S_L);
  bool voxel(const geometry::Index3& index, float* distance_m, float* weight) const;

  /// The fused voxels in the form in which a local map hands over its content, with the measured normals and distances.
  struct Measured {
    occupancy::MapContent content;                    ///< blocks sorted by index; everything was observed
    std::vector<std::vector<SurfaceNormal>> normals;  ///< normals of the occupied voxels of each block
    std::vector<std::vector<float>> distances;        ///< distances of all voxels of each block, see make_content()
  };
  Measured measured() const;
  void clear() {
    blocks_.clear();
    scan_ = 0;
  }

 private:
  struct Voxel {
    float distance = 0.f;  ///< m
    float weight = 0.f;
    std::uint32_t mark = 0;  ///< number of the last scan that reached the voxel, times 4, plus kSeen and kEnd
  };
  using Block = std::array<Voxel, geometry::kBlockVolume>;
  static constexpr std::uint32_t kSeen = 1;  ///< a ray of that scan went through the voxel
  static constexpr std::uint32_t kEnd = 2;   ///< a point of that scan lies in the voxel
  struct Ray {
    geometry::Vec3 end;
    float weight;
    bool is_clearing;
  };
  enum class Visit { kRefused, kLeftAlone, kNew, kSeen };
  /// The surface at a voxel.
  struct Surface {
    geometry::Vec3f foot;  ///< foot of the voxel centre on the zero level, voxel edges
    SurfaceNormal normal;
  };

  std::vector<Ray> rays_of(const std::vector<geometry::Vec3f>& points_L, const geometry::Pose& T_S_L,
                           Counts* counts) const;
  std::uint32_t group_of(const geometry::Index3& cell);
  void merge(std::vector<Ray>* rays);
  void thin(std::vector<Ray>* rays);
  void mark_ends(const std::vector<Ray>& rays);
  void cast(const geometry::Vec3& origin, const Ray& ray, Counts* counts);
  Visit update(double distance, float weight, bool is_own_end, Voxel* voxel) const;
  void fuse(float distance, float weight, Voxel* voxel) const;
  Block* open(const geometry::Index3& index);
  void add_measured(const geometry::Index3& index, const Block& block, Measured* out) const;
  std::optional<Surface> surface_at(const geometry::Index3& voxel, float distance) const;
  bool observed(const geometry::Index3& index, float* distance) const;
  bool has_free_neighbor(const geometry::Index3& index) const;
  bool gradient(const geometry::Index3& index, float distance, geometry::Vec3f* out) const;

  ProjectiveConfig config_;
  std::unordered_map<geometry::Index3, std::unique_ptr<Block>, geometry::Index3Hash> blocks_;
  containers::NumberTable<geometry::Index3, geometry::Index3Hash> groups_;
  std::vector<geometry::Index3> group_cells_;  ///< cells of the groups, by number
  std::uint32_t scan_ = 0;                     ///< 30 bits, never 0
};

}  // namespace voxnav::submap
