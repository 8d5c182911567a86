// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "voxnav/geometry/pose.hpp"

namespace voxnav_simulation {

/// The last poses of a body, bounded in number. Poses between them are interpolated.
class PoseHistory {
 public:
  explicit PoseHistory(std::size_t capacity) : capacity_(capacity) {}

  /// Appends a pose. A pose with the newest stamp replaces the pose that had it. An older stamp means that time was set
  /// back: all earlier poses are then removed, and the result is false.
  bool add(const voxnav::geometry::StampedPose& pose);

  std::optional<voxnav::base::StampNs> oldest_ns() const;
  std::optional<voxnav::base::StampNs> newest_ns() const;
  /// Returns the interpolated pose at a stamp, or nothing outside of the known stamps: poses are never extrapolated.
  std::optional<voxnav::geometry::Pose> at(voxnav::base::StampNs stamp_ns) const;

 private:
  std::size_t capacity_;
  std::deque<voxnav::geometry::StampedPose> poses_;
};

}  // namespace voxnav_simulation
