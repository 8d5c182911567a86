// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/graph/trajectory.hpp"

#include <algorithm>
#include <stdexcept>

namespace voxnav::graph {
namespace {

geometry::Pose corrected(const SubmapCorrection& correction, const geometry::Pose& T_O_B) {
  return correction.T_W_S * correction.T_O_S.inverse() * T_O_B;
}

geometry::Pose corrected_at(const std::vector<SubmapCorrection>& corrections, const geometry::StampedPose& pose) {
  const auto after =
      std::upper_bound(corrections.begin(), corrections.end(), pose.stamp_ns,
                       [](base::StampNs stamp_ns, const SubmapCorrection& c) { return stamp_ns < c.stamp_ns; });
  if (after == corrections.begin()) return corrected(corrections.front(), pose.pose);
  if (after == corrections.end()) return corrected(corrections.back(), pose.pose);
  const auto before = after - 1;
  const double ratio =
      static_cast<double>(pose.stamp_ns - before->stamp_ns) / static_cast<double>(after->stamp_ns - before->stamp_ns);
  return geometry::interpolate(corrected(*before, pose.pose), corrected(*after, pose.pose), ratio);
}

}  // namespace

std::vector<geometry::StampedPose> correct_trajectory(const std::vector<geometry::StampedPose>& trajectory,
                                                      const std::vector<SubmapCorrection>& corrections) {
  if (corrections.empty()) throw std::invalid_argument("corrections must hold at least one submap");
  for (std::size_t i = 1; i < corrections.size(); ++i) {
    if (corrections[i].stamp_ns <= corrections[i - 1].stamp_ns) {
      throw std::invalid_argument("corrections must have strictly rising stamps");
    }
  }
  std::vector<geometry::StampedPose> out;
  out.reserve(trajectory.size());
  for (const geometry::StampedPose& pose : trajectory) out.push_back({pose.stamp_ns, corrected_at(corrections, pose)});
  return out;
}

}  // namespace voxnav::graph
