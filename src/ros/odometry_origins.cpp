// SPDX-License-Identifier: BSD-3-Clause
#include "odometry_origins.hpp"

#include <iterator>

namespace voxnav_ros {

voxnav::geometry::Pose expressed(const voxnav::geometry::Pose& T_new_old, const voxnav::geometry::Pose& T_old_X) {
  return T_new_old.matrix() == voxnav::geometry::Pose::Identity().matrix() ? T_old_X : T_new_old * T_old_X;
}

void OdometryOrigins::change(const std::string& frame, const Pose& T_new_old, std::uint32_t first_id) {
  for (auto& [name, T_now_former] : former_) T_now_former = T_new_old * T_now_former;
  for (auto& [id, T_now_then] : by_first_) T_now_then = T_new_old * T_now_then;
  T_now_first_ = T_new_old * T_now_first_;
  former_[frame_] = T_new_old;
  former_.erase(frame);
  by_first_[first_id] = Pose::Identity();
  frame_ = frame;
}

void OdometryOrigins::begin(const std::string& frame) {
  *this = OdometryOrigins();
  frame_ = frame;
}

std::optional<OdometryOrigins::Pose> OdometryOrigins::from(const std::string& frame) const {
  if (frame == frame_) return Pose::Identity();
  const auto found = former_.find(frame);
  if (found == former_.end()) return std::nullopt;
  return found->second;
}

OdometryOrigins::Pose OdometryOrigins::from_that_of(std::uint32_t id) const {
  const auto next = by_first_.upper_bound(id);
  return next == by_first_.begin() ? T_now_first_ : std::prev(next)->second;
}

}  // namespace voxnav_ros
