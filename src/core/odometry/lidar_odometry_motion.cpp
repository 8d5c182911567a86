// SPDX-License-Identifier: BSD-3-Clause
// How LidarOdometry predicts the motion of the body before it looks at a cloud, and deskews the cloud with it.
#include <algorithm>
#include <cmath>

#include "odometry/lidar_odometry_impl.hpp"
#include "odometry/odometry_limits.hpp"

namespace voxnav::odometry {
namespace {

using geometry::Pose;
using geometry::Vec3;

constexpr double kFirstDt_s = 0.1;
constexpr int kSweepBins = 512;
constexpr double kMaxSweep_s = 1.0;

double spacing_m(const LidarOdometryConfig& c) { return c.voxel_size_m / std::sqrt(c.max_points_per_voxel); }

}  // namespace

LidarOdometry::Impl::Prediction LidarOdometry::Impl::predict(base::StampNs stamp_ns) const {
  Prediction out;
  out.T_O_B = T_O_B_;
  out.dt_s = has_time_ ? base::to_seconds(stamp_ns - stamp_ns_) : kFirstDt_s;
  if (!has_time_) {
    out.has_imu = config_.use_imu && imu_.rotation(stamp_ns, stamp_ns, gyro_bias_, config_.imu_max_gap_s).has_value();
    return out;
  }
  const auto turned =
      config_.use_imu ? imu_.rotation(stamp_ns_, stamp_ns, gyro_bias_, config_.imu_max_gap_s) : std::nullopt;
  out.has_imu = turned.has_value();
  const double dt = std::min(out.dt_s, kMaxScanGap_s);
  const Eigen::Quaterniond rotation = turned ? *turned : exp_so3(angular_velocity_B_ * dt);
  // Without an IMU a vehicle that turns is expected to go on along its curve, so that its velocity turns with it. With
  // one the velocity is expected to stay the same in frame O.
  const Eigen::Quaterniond half = turned ? Eigen::Quaterniond::Identity() : exp_so3(angular_velocity_B_ * dt);
  const Vec3 velocity_B = T_O_B_.linear().transpose() * velocity_O_;
  out.T_O_B.translation() += T_O_B_.linear() * (half * velocity_B) * dt;
  out.T_O_B.linear() = (T_O_B_.linear() * rotation.toRotationMatrix());
  out.T_O_B.linear() = Eigen::Quaterniond(out.T_O_B.linear()).normalized().toRotationMatrix();
  return out;
}

Eigen::Matrix3d LidarOdometry::Impl::rotation_from(base::StampNs stamp_ns, double t_s, bool has_imu) const {
  if (has_imu) {
    const auto turned = imu_.rotation(stamp_ns, stamp_ns + base::from_seconds(t_s), gyro_bias_, config_.imu_max_gap_s);
    if (turned) return turned->toRotationMatrix();
  }
  return exp_so3(angular_velocity_B_ * t_s).toRotationMatrix();
}

LidarOdometry::Impl::Sweep LidarOdometry::Impl::sweep_of(base::StampNs stamp_ns, const std::vector<float>& times_s) {
  float last_s = 0.0F;
  for (float t : times_s) {
    if (t > last_s && t <= kMaxSweep_s) last_s = t;
  }
  return {stamp_ns, stamp_ns + base::from_seconds(0.5 * last_s), last_s};
}

std::vector<Eigen::Isometry3f> LidarOdometry::Impl::poses_within(const Sweep& sweep,
                                                                 const Prediction& prediction) const {
  std::vector<Eigen::Isometry3f> out(sweep.duration_s > 0.0 ? kSweepBins : 1);
  const Vec3 velocity_B = prediction.T_O_B.linear().transpose() * velocity_O_;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double t = sweep.duration_s * (static_cast<double>(i) / (kSweepBins - 1) - 0.5);
    Pose moved = Pose::Identity();
    if (out.size() > 1) {
      moved.linear() = rotation_from(sweep.middle_ns, t, prediction.has_imu);
      moved.translation() = velocity_B * t;
    }
    out[i] = (moved * T_B_L_).cast<float>();
  }
  return out;
}

void LidarOdometry::Impl::prepare_points(const Sweep& sweep, const std::vector<Vec3f>& points_L,
                                         const std::vector<float>& times_s, const Prediction& prediction) {
  // The steps are so fine that each point may take the nearest pose instead of an interpolated one.
  const std::vector<Eigen::Isometry3f> poses = poses_within(sweep, prediction);
  const float to_bin = poses.size() == 1 ? 0.0F : static_cast<float>((kSweepBins - 1) / sweep.duration_s);
  const auto min_sq = static_cast<float>(config_.min_range_m * config_.min_range_m);
  const auto max_sq = static_cast<float>(config_.max_range_m * config_.max_range_m);
  deskewed_.clear();
  for (std::size_t i = 0; i < points_L.size(); ++i) {
    const float range_sq = points_L[i].squaredNorm();
    const float t = times_s.empty() ? 0.0F : times_s[i];
    const bool has_time = t >= 0.0F && t <= kMaxSweep_s;
    if (!std::isfinite(range_sq) || !has_time) {
      ++counters_.points_refused;
    } else if (range_sq >= min_sq && range_sq <= max_sq) {
      const float bin = t * to_bin + 0.5F;  // rounded by the conversion
      deskewed_.push_back(poses[static_cast<std::size_t>(bin)] * points_L[i]);
    }
  }
  downsampler_.run(deskewed_, spacing_m(config_), &fine_);
  downsampler_.run(fine_, config_.voxel_size_m * 0.6, &source_);
}

}  // namespace voxnav::odometry
