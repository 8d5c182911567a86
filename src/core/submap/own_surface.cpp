// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/own_surface.hpp"

#include <cmath>

namespace voxnav::submap {
namespace {

std::shared_ptr<const Submap> own_part(const Submap& submap, double reach_m) {
  SubmapConfig config = submap.config();
  config.max_distance_m = reach_m;
  config.certified = false;  // registration needs the surface points, not the voxels around them
  return Submap::from_field(submap.field()->own_surface(), submap.resolution_m(), submap.T_S_G(), config);
}

}  // namespace

OwnSurface::OwnSurface(const Submap& submap)
    : own_(own_part(submap, submap.config().band_voxels * submap.resolution_m())),
      content_(own_->field()),
      reach_m_(submap.config().band_voxels * submap.resolution_m()) {}

bool OwnSurface::sample(const geometry::Vec3& p_S, double* distance_m, geometry::Vec3* gradient) const {
  double distance = 0.0;
  geometry::Vec3 slope = geometry::Vec3::Zero();
  if (!own_->sample_in(*content_, p_S, &distance, gradient ? &slope : nullptr) || !(std::abs(distance) < reach_m_))
    return false;
  *distance_m = distance;
  if (gradient) *gradient = slope;
  return true;
}

std::shared_ptr<const geometry::DistanceField> registration_field(const std::shared_ptr<const Submap>& submap) {
  if (submap->field()->has_values()) return submap;
  return std::make_shared<OwnSurface>(*submap);
}

}  // namespace voxnav::submap
