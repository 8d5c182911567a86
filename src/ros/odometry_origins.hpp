// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "voxnav/geometry/pose.hpp"

namespace voxnav_ros {

/// Expresses a pose in another origin. Where nothing changes it stays as it is to the last bit, as offline maps have
/// it: a product with the identity would turn -0 into 0.
voxnav::geometry::Pose expressed(const voxnav::geometry::Pose& T_new_old, const voxnav::geometry::Pose& T_old_X);

/// The origins of the odometry, one after another, and how poses in former ones are expressed in the newest. Submaps
/// are numbered in the order in which they came.
class OdometryOrigins {
 public:
  using Pose = voxnav::geometry::Pose;

  const std::string& frame() const { return frame_; }
  /// Takes over another origin.
  /// @param first_id  id of the first submap whose pose will be in it
  void change(const std::string& frame, const Pose& T_new_old, std::uint32_t first_id);
  /// Begins anew with an origin, to which no former one relates.
  void begin(const std::string& frame);

  /// Returns the transform from an origin to the newest one; nothing if they are not related.
  std::optional<Pose> from(const std::string& frame) const;
  /// Returns the transform to the newest origin from the one that was the newest when this submap came.
  Pose from_that_of(std::uint32_t id) const;

 private:
  std::string frame_;
  std::map<std::string, Pose> former_;      ///< T_now_former by frame
  std::map<std::uint32_t, Pose> by_first_;  ///< T_now_then of submaps from this id on; lower ids: of the first origin
  Pose T_now_first_ = Pose::Identity();
};

}  // namespace voxnav_ros
