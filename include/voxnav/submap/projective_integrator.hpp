// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// Which rays of a scan are cast.
enum class RayRule {
  kSimple,  ///< one ray for each point
  kMerged,  ///< one ray for each end voxel
  kFast     ///< one ray for each half voxel, and only through voxels that no other ray of the scan crossed
};
constexpr auto words_of(RayRule) { return std::array{"simple", "merged", "fast"}; }

/// How the weight of a point depends on its range.
enum class RangeWeighting { kConstant, kInverseSquare };
constexpr auto words_of(RangeWeighting) { return std::array{"constant", "inverse_square"}; }

struct ProjectiveConfig {
  double resolution_m = 0.4;
  double truncation_m = 0.8;
  double min_range_m = 0.5;
  double max_range_m = 26.0;
  RayRule rule = RayRule::kMerged;
  RangeWeighting weighting = RangeWeighting::kConstant;
  bool use_drop_off = true;
  bool use_anti_grazing = true;
  bool use_carving = true;
  double max_weight = 10000.0;
  double min_weight = 0.5;
  int max_blocks = 20000;

  template <class V>
  static void fields(V&& v) {
    using C = ProjectiveConfig;
    v("resolution_m", &C::resolution_m, base::in(0.02, 5.0), "m", "edge of one voxel");
    v("truncation_m", &C::truncation_m, base::in(0.04, 20.0), "m", "distances are kept up to here; at least 2 voxels");
    v("min_range_m", &C::min_range_m, base::in(0.0, 10.0), "m", "nearer points are ignored");
    v("max_range_m", &C::max_range_m, base::in(1.0, 300.0), "m", "farther points only clear free space up to here");
    v("rule", &C::rule, base::one_of<RayRule>(), "",
      "one ray per point, per end voxel, or per half voxel and only through voxels not yet seen");
    v("weighting", &C::weighting, base::one_of<RangeWeighting>(), "", "weight of a point by its range");
    v("use_drop_off", &C::use_drop_off, base::any(), "", "weights fall linearly to zero behind the surface");
    v("use_anti_grazing", &C::use_anti_grazing, base::any(), "",
      "rays do not change voxels in which other points of the scan end");
    v("use_carving", &C::use_carving, base::any(), "",
      "rays start at the sensor; else only the truncation band is updated");
    v("max_weight", &C::max_weight, base::in(1.0, 1e9), "", "weights saturate here");
    v("min_weight", &C::min_weight, base::in(1e-6, 1e6), "", "a voxel is observed from this weight on");
    v("max_blocks", &C::max_blocks, base::in(1, 1000000), "", "blocks of one submap; space beyond them is not filled");
  }
  std::vector<std::string> problems() const;
};

/// Fuses truncated signed distances along rays (TSDF), for comparison with submaps made from occupancy and for sensors
/// without a local map. Distances are too large at grazing angles, and rays outvote thin things unless anti-grazing is
/// on. Deterministic. Not thread-safe.
/// Source: Curless & Levoy, SIGGRAPH 1996, equations 1 and 2; rules and weights as in Oleynikova et al., Voxblox, IROS
/// 2017, section IV, but with the range weight by the true range, not by z.
class ProjectiveIntegrator {
 public:
  struct Counts {
    std::size_t points = 0;
    std::size_t dropped = 0;  ///< points that are not finite or too near
    std::size_t rays = 0;
    std::size_t voxels = 0;   ///< voxel updates
    std::size_t refused = 0;  ///< voxel updates refused because max_blocks blocks exist
  };

  explicit ProjectiveIntegrator(const ProjectiveConfig& config);
  ~ProjectiveIntegrator();
  ProjectiveIntegrator(ProjectiveIntegrator&&) noexcept;
  ProjectiveIntegrator& operator=(ProjectiveIntegrator&&) noexcept;

  /// Fuses one scan.
  /// @param points_L  points in the sensor frame, m; there may be none
  /// @param T_S_L     pose of the sensor at scan time
  /// @throws std::invalid_argument on an invalid pose
  /// @complexity O(rays * range / voxel)
  Counts integrate(const std::vector<geometry::Vec3f>& points_L, const geometry::Pose& T_S_L);

  /// Reads distance and weight at the centre of a voxel; returns false if nothing was fused there.
  bool voxel(const geometry::Index3& index, float* distance_m, float* weight) const;

  /// Makes a submap of the fused distances. Voxels through which the surface passes become occupied, those in front of
  /// it free, and those behind it stay unknown. The integrator is empty afterwards.
  /// @param T_S_G  frame S of the poses given to integrate(), in the frame of the submap
  std::shared_ptr<Submap> finish(const SubmapConfig& config, const geometry::Pose& T_S_G = geometry::Pose::Identity());

 private:
  class Volume;
  std::unique_ptr<Volume> volume_;
};

}  // namespace voxnav::submap
