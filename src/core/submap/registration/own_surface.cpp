// SPDX-License-Identifier: BSD-3-Clause
#include "submap/registration/own_surface.hpp"

#include <cmath>

#include "submap/registration/seen_side.hpp"

namespace voxnav::submap {
namespace {

CompressedField own_surface_of(const Submap& submap, const std::vector<geometry::StampedPose>& T_S_B) {
  CompressedField out = submap.field()->own_surface();
  if (T_S_B.empty() || out.has_values()) return out;
  std::vector<geometry::StampedPose> T_G_B = T_S_B;
  const geometry::Pose T_G_S = submap.T_S_G().inverse(Eigen::Isometry);
  for (geometry::StampedPose& pose : T_G_B) pose.pose = T_G_S * pose.pose;
  move_to_middles(submap.resolution_m(), T_G_B, &out);
  return out;
}

std::shared_ptr<const Submap> own_part(const Submap& submap, const std::vector<geometry::StampedPose>& T_S_B,
                                       double reach_m) {
  SubmapConfig config = submap.config();
  config.max_distance_m = reach_m;
  config.certified = false;  // registration needs the surface points, not the voxels around them
  return Submap::from_field(own_surface_of(submap, T_S_B), submap.resolution_m(), submap.T_S_G(), config);
}

}  // namespace

OwnSurface::OwnSurface(const Submap& submap, const std::vector<geometry::StampedPose>& T_S_B)
    : own_(own_part(submap, T_S_B, submap.config().band_voxels * submap.resolution_m())),
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

std::shared_ptr<const geometry::DistanceField> registration_field(const std::shared_ptr<const Submap>& submap,
                                                                  const std::vector<geometry::StampedPose>& T_S_B) {
  if (submap->field()->has_values()) return submap;
  return std::make_shared<OwnSurface>(*submap, T_S_B);
}

}  // namespace voxnav::submap
