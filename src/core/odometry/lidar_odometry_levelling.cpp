// SPDX-License-Identifier: BSD-3-Clause
// How LidarOdometry finds out where up is while it flies, and turns its frame upright.
#include <algorithm>
#include <cmath>

#include "odometry/lidar_odometry_impl.hpp"

namespace voxnav::odometry {
namespace {

using geometry::Pose;
using geometry::Vec3;

/// Over so long errors of the positions tilt the frame by little; and what must do when there is no more.
constexpr double kLevelAfter_s = 2.0, kLevelAfterAtEnd_s = 0.3;
/// Over so long a tilt of the frame is told from errors of the positions.
constexpr double kTiltAfter_s = 5.0;
constexpr double kTiltToTell_rad = 0.035, kShareToTell = 0.5;
/// The first sweeps are deskewed without a velocity, and their positions are off by that.
constexpr std::uint64_t kCloudsToSettle = 6;

Matrix6 turned(const Matrix6& covariance, const Eigen::Matrix3d& R) {
  Matrix6 out;
  for (int i : {0, 3}) {
    for (int j : {0, 3}) out.block<3, 3>(i, j) = R * covariance.block<3, 3>(i, j) * R.transpose();
  }
  return out;
}

}  // namespace

/// Adds the span since the cloud before, if the motion over it is known. Where it is not, a new span begins.
void LidarOdometry::Impl::weigh_gravity(const Motion& before, base::StampNs now_ns) {
  if (!config_.use_imu) return;
  const bool is_settled = before.is_known && has_velocity_ && coasted_s_ == 0.0 && scan_ > kCloudsToSettle;
  const auto force = is_settled ? imu_.mean_force(before.stamp_ns, now_ns) : std::nullopt;
  if (!force) return gravity_.clear();
  const Eigen::Matrix3d R_O_B = geometry::interpolate(before.T_O_B, T_O_B_, 0.5).linear();
  gravity_.add(R_O_B * force->mean, before.T_O_B.translation(), T_O_B_.translation(),
               base::to_seconds(now_ns - before.stamp_ns));
}

std::optional<Pose> LidarOdometry::Impl::level(bool is_end) {
  const auto up_O = gravity_.up_O(is_end ? kLevelAfterAtEnd_s : kLevelAfter_s);
  if (is_level_ || !up_O) return std::nullopt;
  Pose turn = Pose::Identity();
  turn.linear() = levelling(*up_O);
  map_.transform(turn.cast<float>());
  T_O_B_ = turn * T_O_B_;
  last_.T_O_B = turn * last_.T_O_B;
  if (observed_T_O_B_) observed_T_O_B_ = turn * *observed_T_O_B_;
  velocity_O_ = turn.linear() * velocity_O_;
  for (Matrix6* covariance : {&local_covariance_, &lost_covariance_, &last_.covariance}) {
    *covariance = turned(*covariance, turn.linear());
  }
  gravity_.clear();
  is_level_ = true;
  return turn;
}

std::optional<double> LidarOdometry::Impl::tilt_rad() const {
  const auto up_O = gravity_.up_O(kTiltAfter_s);
  if (!up_O) return std::nullopt;
  return std::acos(std::min(1.0, std::max(-1.0, up_O->z())));
}

std::vector<std::string> LidarOdometry::Impl::problems() const {
  std::vector<std::string> out;
  const std::string stamps = base::describe(imu_stamps());
  if (!stamps.empty()) out.push_back("stamps of " + std::to_string(counters_.imu_samples) + " IMU samples: " + stamps);
  if (counters_.imu_not_finite > 0) {
    out.push_back(std::to_string(counters_.imu_not_finite) + " IMU samples were left out, as they are not finite");
  }
  if (counters_.imu_samples > 0 && counters_.scans_without_imu > kShareToTell * static_cast<double>(counters_.clouds)) {
    out.push_back(std::to_string(counters_.scans_without_imu) + " of " + std::to_string(counters_.clouds) +
                  " scans were tracked without the IMU, as no samples are of their time");
  }
  if (counters_.clouds > 0 && !is_level_) {
    const char* const why = !config_.use_imu             ? "the IMU is not used"
                            : counters_.imu_samples == 0 ? "there is no IMU"
                                                         : "the IMU does not show it";
    out.push_back(std::string("nothing tells where down is (") + why + "): the map is as tilted as the first scan was");
  }
  const auto tilt = tilt_rad();
  if (is_level_ && tilt && *tilt > kTiltToTell_rad) {
    out.push_back(
        "the map is tilted against gravity by " + std::to_string(*tilt * 180.0 / M_PI).substr(0, 4) +
        " degrees: the vehicle accelerated when the recording began, or the IMU is mounted otherwise than said");
  }
  return out;
}

}  // namespace voxnav::odometry
