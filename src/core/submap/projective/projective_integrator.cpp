// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/projective_integrator.hpp"

#include "submap/content/make_content.hpp"
#include "submap/projective/projective_volume.hpp"
#include "submap/registration/surface_sampling.hpp"

namespace voxnav::submap {

std::vector<std::string> ProjectiveConfig::problems() const {
  std::vector<std::string> out;
  if (truncation_m < 2.0 * resolution_m) out.emplace_back("truncation_m must be at least two voxels");
  if (min_range_m >= max_range_m) out.emplace_back("min_range_m must be below max_range_m");
  if (max_range_m / resolution_m > 20000.0) out.emplace_back("max_range_m is more than 20000 voxels");
  return out;
}

ProjectiveIntegrator::ProjectiveIntegrator(const ProjectiveConfig& config)
    : volume_(std::make_unique<Volume>(config)) {}

ProjectiveIntegrator::~ProjectiveIntegrator() = default;
ProjectiveIntegrator::ProjectiveIntegrator(ProjectiveIntegrator&&) noexcept = default;
ProjectiveIntegrator& ProjectiveIntegrator::operator=(ProjectiveIntegrator&&) noexcept = default;

ProjectiveIntegrator::Counts ProjectiveIntegrator::integrate(const std::vector<geometry::Vec3f>& points_L,
                                                             const geometry::Pose& T_S_L) {
  return volume_->integrate(points_L, T_S_L);
}

bool ProjectiveIntegrator::voxel(const geometry::Index3& index, float* distance_m, float* weight) const {
  return volume_->voxel(index, distance_m, weight);
}

std::shared_ptr<Submap> ProjectiveIntegrator::finish(const SubmapConfig& config, const geometry::Pose& T_S_G) {
  base::checked(config);
  const Volume::Measured measured = volume_->measured();
  SubmapContent content = make_content(measured.content, config.band_voxels, &measured.distances);
  auto submap = Submap::from_packed(std::move(content), measured.content.resolution_m, T_S_G, config);
  submap->set_surface_points(sample_surface(measured.content, measured.normals, T_S_G, config.max_surface_points));
  volume_->clear();
  return submap;
}

}  // namespace voxnav::submap
