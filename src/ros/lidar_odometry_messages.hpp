// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Odometry.h>

#include "voxnav/OdometryQuality.h"
#include "voxnav/odometry/lidar_odometry.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {

inline geometry_msgs::Vector3 to_vector_msg(const voxnav::geometry::Vec3& v) {
  geometry_msgs::Vector3 out;
  out.x = v.x();
  out.y = v.y();
  out.z = v.z();
  return out;
}

inline msg::OdometryQuality quality_msg(const voxnav::odometry::OdometryResult& result,
                                        const std_msgs::Header& header) {
  const voxnav::odometry::Quality& q = result.quality;
  msg::OdometryQuality out;
  out.header = header;
  out.state = static_cast<std::uint8_t>(q.state);
  out.reason = q.reason;
  out.inlier_ratio = q.inlier_ratio;
  out.residual_m = q.residual_m;
  out.iterations = static_cast<std::uint32_t>(q.iterations);
  out.num_points = static_cast<std::uint32_t>(q.num_points);
  for (std::size_t i = 0; i < 6; ++i) out.information_eigenvalues[i] = q.eigenvalues[i];
  out.is_degenerate = q.is_degenerate;
  return out;
}

/// Pose in the odometry frame, twist in the body frame; the twist of a coasting body is as uncertain as its speed.
inline nav_msgs::Odometry odometry_msg(const voxnav::odometry::OdometryResult& result, const std_msgs::Header& header,
                                       const std::string& body_frame,
                                       const voxnav::odometry::LidarOdometryConfig& config) {
  nav_msgs::Odometry out;
  out.header = header;
  out.child_frame_id = body_frame;
  out.pose.pose = to_msg(result.T_O_B);
  auto to = out.pose.covariance.begin();
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) *to++ = result.covariance(r, c);
  }
  out.twist.twist.linear = to_vector_msg(result.velocity_B);
  out.twist.twist.angular = to_vector_msg(result.angular_velocity_B);
  const bool is_tracking = result.quality.state == voxnav::odometry::OdometryState::kTracking;
  const double speed = is_tracking ? config.velocity_noise_mps : config.max_speed_mps;
  const double rate = is_tracking ? 0.1 : 1.0;
  for (std::size_t i = 0; i < 6; ++i) out.twist.covariance[7 * i] = i < 3 ? speed * speed : rate * rate;
  return out;
}

}  // namespace voxnav_ros
