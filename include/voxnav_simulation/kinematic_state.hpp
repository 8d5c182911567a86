// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/geometry/pose.hpp"

namespace voxnav_simulation {

using voxnav::geometry::Pose;
using voxnav::geometry::Vec3;

/// The full state of a reference: position, heading and their first three derivatives.
struct KinematicState {
  Vec3 position = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();
  Vec3 acceleration = Vec3::Zero();
  Vec3 jerk = Vec3::Zero();
  double heading_rad = 0;
  double heading_rate = 0;
  double heading_acceleration = 0;
  double heading_jerk = 0;
};

/// A position with a heading, in the frame of the estimate.
struct HeadedPoint {
  Vec3 position = Vec3::Zero();
  double heading_rad = 0;
};

bool is_finite(const HeadedPoint& point);
bool is_finite(const KinematicState& state);

}  // namespace voxnav_simulation
