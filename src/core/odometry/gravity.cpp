// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/gravity.hpp"

#include <cmath>

namespace voxnav::odometry {
namespace {

using geometry::Vec3;

constexpr double kGravity_mps2 = 9.81;
/// Gravity in m/s^2, g, mg, cm/s^2 and mm/s^2.
constexpr double kNorms[] = {kGravity_mps2, 1.0, 1000.0, 981.0, 9810.0};
constexpr double kNormTolerance = 0.4;
/// Of samples whose directions scatter, the mean is shorter than they are.
constexpr double kLeastAgreement = 0.8;

/// Factor to m/s^2 of samples whose norm at rest would be `norm`.
std::optional<double> scale_of(double norm) {
  for (const double gravity : kNorms) {
    if (std::abs(norm - gravity) <= kNormTolerance * gravity) return kGravity_mps2 / gravity;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Vec3> Gravity::up_at_rest(const MeanForce& force) {
  const double norm = force.mean.norm();
  if (!scale_of(norm) || norm < kLeastAgreement * force.mean_norm) return std::nullopt;
  return Vec3(force.mean / norm);
}

void Gravity::add(const Vec3& force_O, const Vec3& velocity_change_O, double dt_s) {
  force_s_ += force_O * dt_s;
  velocity_change_ += velocity_change_O;
  span_s_ += dt_s;
}

std::optional<Vec3> Gravity::up_O(double least_s) const {
  if (span_s_ < least_s || span_s_ <= 0.0) return std::nullopt;
  const Vec3 force = force_s_ / span_s_;
  const auto scale = scale_of(force.norm());
  if (!scale) return std::nullopt;
  return Vec3((*scale * force - velocity_change_ / span_s_).normalized());
}

Eigen::Matrix3d levelling(const Vec3& up) {
  const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(up, Vec3::UnitZ());
  const Eigen::AngleAxisd unturn(-geometry::yaw_of(geometry::Pose(q)), Vec3::UnitZ());
  return (unturn * q).toRotationMatrix();
}

}  // namespace voxnav::odometry
