// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/gravity.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace voxnav::odometry {
namespace {

using geometry::Vec3;

constexpr double kGravity_mps2 = 9.81;
/// The norms of gravity in m/s^2, g, mg, cm/s^2 and mm/s^2.
constexpr double kNorms[] = {kGravity_mps2, 1.0, 1000.0, 981.0, 9810.0};
constexpr double kNormTolerance = 0.4;
/// The least ratio of the norm of the mean to the mean norm, which is lower if the directions of the samples scatter.
constexpr double kLeastAgreement = 0.8;

/// Returns the factor that converts samples with this norm at rest to m/s^2, or nothing if the norm fits no unit.
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

void Gravity::add(const Vec3& force_O, const Vec3& from_O, const Vec3& to_O, double dt_s) {
  if (moments_.time[0] == 0.0) note(from_O);
  force_s2_ += force_s_ * dt_s + 0.5 * dt_s * dt_s * force_O;
  force_s_ += force_O * dt_s;
  span_s_ += dt_s;
  note(to_O);
}

void Gravity::note(const Vec3& position_O) {
  double power = 1.0;
  for (std::size_t k = 0; k < moments_.time.size(); ++k, power *= span_s_) {
    moments_.time[k] += power;
    if (k >= moments_.position.size()) continue;
    moments_.position[k] += power * position_O;
    moments_.pushed[k] += power * force_s2_;
  }
}

/// A body at position p with the specific force f moves by p'' = f - g up. Hence the force, integrated twice, minus the
/// positions is a parabola g/2 up t^2 + ..., which is fitted to all of them, because positions are known far better
/// than the velocities between two of them.
std::optional<Vec3> Gravity::up_O(double least_s) const {
  constexpr double kFewest = 4.0;  // the least number of positions that overdetermine a parabola
  if (span_s_ < least_s || span_s_ <= 0.0 || moments_.time[0] < kFewest) return std::nullopt;
  const auto scale = scale_of(force_s_.norm() / span_s_);
  if (!scale) return std::nullopt;
  // Time is in units of the whole span, so that its powers have similar sizes.
  Eigen::Matrix3d normal;
  Eigen::Matrix3d ahead;  // a row for each power
  for (std::size_t row = 0; row < 3; ++row) {
    const double unit = std::pow(span_s_, -static_cast<double>(row));
    ahead.row(static_cast<int>(row)) = unit * (*scale * moments_.pushed[row] - moments_.position[row]).transpose();
    for (std::size_t column = 0; column < 3; ++column) {
      normal(static_cast<int>(row), static_cast<int>(column)) =
          moments_.time[row + column] * std::pow(span_s_, -static_cast<double>(row + column));
    }
  }
  const Vec3 bend = normal.ldlt().solve(ahead).row(2).transpose();
  const double norm = bend.norm();
  if (!(norm > 0.0)) return std::nullopt;
  return Vec3(bend / norm);
}

Eigen::Matrix3d levelling(const Vec3& up) {
  const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(up, Vec3::UnitZ());
  const Eigen::AngleAxisd unturn(-geometry::yaw_of(geometry::Pose(q)), Vec3::UnitZ());
  return (unturn * q).toRotationMatrix();
}

}  // namespace voxnav::odometry
