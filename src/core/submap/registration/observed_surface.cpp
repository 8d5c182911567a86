// SPDX-License-Identifier: BSD-3-Clause
#include "submap/registration/observed_surface.hpp"

#include <cmath>

#include "submap/registration/move_to_middles.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {
namespace {

SubmapContent observed_content_of(const Submap& submap, const std::vector<geometry::StampedPose>& T_S_B) {
  const auto content = submap.content();
  if (content->measured()) return *content;
  SubmapContent out = observed_content(*content);
  if (T_S_B.empty()) return out;
  std::vector<geometry::StampedPose> T_G_B = T_S_B;
  const geometry::Pose T_G_S = submap.T_S_G().inverse(Eigen::Isometry);
  for (geometry::StampedPose& pose : T_G_B) pose.pose = T_G_S * pose.pose;
  move_to_middles(submap.resolution_m(), T_G_B, &out);
  return out;
}

std::shared_ptr<const Submap> observed_part(const Submap& submap, const std::vector<geometry::StampedPose>& T_S_B,
                                            double reach_m) {
  SubmapConfig config = submap.config();
  config.max_distance_m = reach_m;
  config.certified = false;  // registration needs the surface points, not the voxels around them
  return Submap::from_packed(observed_content_of(submap, T_S_B), submap.resolution_m(), submap.T_S_G(), config);
}

}  // namespace

ObservedSurface::ObservedSurface(const Submap& submap, const std::vector<geometry::StampedPose>& T_S_B)
    : observed_(observed_part(submap, T_S_B, submap.config().band_voxels * submap.resolution_m())),
      content_(observed_->content()),
      reach_m_(submap.config().band_voxels * submap.resolution_m()) {}

bool ObservedSurface::sample(const geometry::Vec3& p_S, double* distance_m, geometry::Vec3* gradient) const {
  double distance = 0.0;
  geometry::Vec3 slope = geometry::Vec3::Zero();
  const bool is_known = observed_->sample_in(*content_, p_S, &distance, gradient ? &slope : nullptr);
  if (!is_known || !(std::abs(distance) < reach_m_)) return false;
  *distance_m = distance;
  if (gradient) *gradient = slope;
  return true;
}

std::shared_ptr<const geometry::DistanceField> registration_field(const std::shared_ptr<const Submap>& submap,
                                                                  const std::vector<geometry::StampedPose>& T_S_B) {
  if (submap->content()->measured()) return submap;
  return std::make_shared<ObservedSurface>(*submap, T_S_B);
}

}  // namespace voxnav::submap
