// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/graph/correct_trajectory.hpp"

#include <algorithm>
#include <stdexcept>

namespace voxnav::graph {
namespace {

geometry::Pose corrected(const SubmapCorrection& correction, const geometry::Pose& T_O_B) {
  return correction.T_W_S * correction.T_O_S.inverse() * T_O_B;
}

/// Returns the share of the time between the middles of two submaps that has passed at a stamp.
double share_of_way(const SubmapCorrection& from, base::StampNs stamp_ns, const SubmapCorrection& to) {
  return static_cast<double>(stamp_ns - from.middle_ns()) / static_cast<double>(to.middle_ns() - from.middle_ns());
}

geometry::Pose corrected_at(const std::vector<SubmapCorrection>& corrections, const geometry::StampedPose& pose) {
  const auto after =
      std::upper_bound(corrections.begin(), corrections.end(), pose.stamp_ns,
                       [](base::StampNs stamp_ns, const SubmapCorrection& c) { return stamp_ns < c.middle_ns(); });
  if (after == corrections.begin()) return corrected(corrections.front(), pose.pose);
  if (after == corrections.end()) return corrected(corrections.back(), pose.pose);
  const auto before = after - 1;
  const double ratio = share_of_way(*before, pose.stamp_ns, *after);
  return geometry::interpolate(corrected(*before, pose.pose), corrected(*after, pose.pose), ratio);
}

void check_middles(const std::vector<SubmapCorrection>& corrections) {
  for (std::size_t i = 1; i < corrections.size(); ++i) {
    if (corrections[i].middle_ns() <= corrections[i - 1].middle_ns()) {
      throw std::invalid_argument("corrections must have strictly rising stamps");
    }
  }
}

/// Returns the motion of a submap at a time towards its neighbour, relative to its pose in the middle of its time.
geometry::Pose bent_towards(const SubmapCorrection& neighbour, const SubmapCorrection& own, base::StampNs stamp_ns,
                            double max_shift_m) {
  const double ratio = std::clamp(share_of_way(own, stamp_ns, neighbour), 0.0, 1.0);
  const geometry::Pose there = own.T_W_S.inverse() * corrected(neighbour, own.T_O_S);
  const geometry::Pose out = geometry::interpolate(geometry::Pose::Identity(), there, ratio);
  return out.translation().norm() <= max_shift_m ? out : geometry::Pose::Identity();
}

}  // namespace

std::vector<geometry::StampedPose> correct_trajectory(const std::vector<geometry::StampedPose>& trajectory,
                                                      const std::vector<SubmapCorrection>& corrections) {
  if (corrections.empty()) throw std::invalid_argument("corrections must hold at least one submap");
  check_middles(corrections);
  std::vector<geometry::StampedPose> out;
  out.reserve(trajectory.size());
  for (const geometry::StampedPose& pose : trajectory) out.push_back({pose.stamp_ns, corrected_at(corrections, pose)});
  return out;
}

std::vector<geometry::Bend> bends_of(const std::vector<SubmapCorrection>& corrections, double max_shift_m) {
  check_middles(corrections);
  std::vector<geometry::Bend> out(corrections.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const SubmapCorrection& own = corrections[i];
    if (i > 0) out[i].T_S_begin = bent_towards(corrections[i - 1], own, own.start_ns, max_shift_m);
    if (i + 1 < out.size()) out[i].T_S_end = bent_towards(corrections[i + 1], own, own.end_ns, max_shift_m);
  }
  return out;
}

}  // namespace voxnav::graph
