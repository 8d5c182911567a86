// SPDX-License-Identifier: BSD-3-Clause
// How LidarOdometry uses a registration: it decides whether to trust it, and updates pose, velocity and covariance.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "odometry/lidar_odometry_impl.hpp"
#include "odometry/odometry_limits.hpp"

namespace voxnav::odometry {
namespace {

using geometry::Pose;
using geometry::Vec3;

constexpr double kBiasGain = 0.02;
constexpr double kMaxBias_radps = 0.2;
/// Drift of rotation per drift of position. With the default drift_ratio it makes a degree on a hundred metres.
constexpr double kRotationPerTranslationDrift_radpm = 0.04;

std::string number(double value) {
  const std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 3);
}

}  // namespace

Matrix6 LidarOdometry::Impl::predicted_covariance(const Prediction& prediction) const {
  const double span = prediction.dt_s + coasted_s_;
  const double acceleration_m = 0.5 * config_.acceleration_noise_mps2 * (span * span - coasted_s_ * coasted_s_);
  const double unknown_m = has_velocity_ ? 0.0 : 0.5 * config_.max_speed_mps * prediction.dt_s;
  const double rotation =
      (prediction.has_imu ? config_.gyro_noise_radps : 1.0) * std::min(prediction.dt_s, kMaxScanGap_s);
  const double velocity_m = config_.velocity_noise_mps * prediction.dt_s;
  const double translation_var = acceleration_m * acceleration_m + velocity_m * velocity_m + unknown_m * unknown_m;
  return local_covariance_ + diagonal(translation_var, rotation * rotation + 1e-8);
}

LidarOdometry::Impl::Explanation LidarOdometry::Impl::distrust(const RegistrationResult& found,
                                                               const Prediction& prediction) const {
  if (found.num_matched < config_.min_matched_points) {
    return {OdometryReason::kFewMatches, "only " + std::to_string(found.num_matched) + " of " +
                                             std::to_string(found.num_points) + " points match the map"};
  }
  if (found.inlier_ratio < config_.min_inlier_ratio) {
    return {OdometryReason::kFewInliers, "inlier ratio is only " + number(found.inlier_ratio)};
  }
  if (!found.has_converged) return {OdometryReason::kNotConverged, "registration did not converge"};
  const double span = prediction.dt_s + coasted_s_;
  const double moved = (found.T_O_B.translation() - prediction.T_O_B.translation()).norm();
  const double reach = has_velocity_ ? config_.max_acceleration_mps2 * span * span : config_.max_speed_mps * span;
  if (moved > 0.3 + reach) {
    return {OdometryReason::kMovedTooFar,
            "registration moved the pose by " + number(moved) + " m, more than motion allows"};
  }
  const double turned = Eigen::AngleAxisd(found.T_O_B.linear().transpose() * prediction.T_O_B.linear()).angle();
  const double turn_reach = prediction.has_imu ? 0.1 + 0.2 * span : 0.5 + span;
  if (turned > turn_reach) {
    return {OdometryReason::kTurnedTooFar,
            "registration turned the pose by " + number(turned) + " rad, more than motion allows"};
  }
  return {OdometryReason::kNone, ""};
}

void LidarOdometry::Impl::adapt_threshold(const Pose& predicted, const Pose& found) {
  const Pose error = predicted.inverse() * found;
  const double angle = Eigen::AngleAxisd(error.linear()).angle();
  const double deviation = error.translation().norm() + 2.0 * config_.max_range_m * 0.5 * std::sin(angle / 2.0);
  // An exponential mean, so that one rough moment does not widen the gate for the rest of the flight.
  sigma_m_ = std::sqrt(0.7 * sigma_m_ * sigma_m_ + 0.3 * deviation * deviation);
  sigma_m_ = std::min(std::max(sigma_m_, config_.min_threshold_m / 3.0), config_.initial_threshold_m);
}

void LidarOdometry::Impl::adapt_gyro_bias(const RegistrationResult& found, const Prediction& prediction) {
  if (!prediction.has_imu || !has_time_ || prediction.dt_s <= 0 || !found.localizability.weak_rotations.empty()) return;
  const Eigen::Quaterniond error(prediction.T_O_B.linear().transpose() * found.T_O_B.linear());
  gyro_bias_ -= kBiasGain * log_so3(error) / prediction.dt_s;
  gyro_bias_ = gyro_bias_.cwiseMin(kMaxBias_radps).cwiseMax(-kMaxBias_radps);
}

/// Takes the mean velocity since a pose was last observed, so that a coast of a few scans leaves the velocity known.
void LidarOdometry::Impl::measure_velocity(const Pose& found, double dt_s) {
  const double span_s = dt_s + coasted_s_;
  has_velocity_ = observed_T_O_B_ && dt_s > 0.0 && span_s <= kMaxScanGap_s;
  if (has_velocity_) {
    velocity_O_ = (found.translation() - observed_T_O_B_->translation()) / span_s;
    angular_velocity_B_ = log_so3(Eigen::Quaterniond(observed_T_O_B_->linear().transpose() * found.linear())) / span_s;
  } else {
    velocity_O_.setZero();
  }
}

void LidarOdometry::Impl::track(const RegistrationResult& found, const Prediction& prediction,
                                const Matrix6& predicted) {
  const Vec3 step = found.T_O_B.translation() - T_O_B_.translation();
  adapt_threshold(prediction.T_O_B, found.T_O_B);
  if (coasted_s_ == 0.0) adapt_gyro_bias(found, prediction);
  measure_velocity(found.T_O_B, prediction.dt_s);
  const double noise_var = config_.measurement_noise_m * config_.measurement_noise_m;
  const Matrix6 information = without_weak_directions(found.information, found.localizability) / noise_var;
  local_covariance_ = (predicted.inverse() + information).inverse();
  local_covariance_ = 0.5 * (local_covariance_ + local_covariance_.transpose()).eval();
  // While the pose only follows the prediction, the gate must stay wide enough to find the surroundings again.
  for (const Vec3& v : found.localizability.weak_translations) {
    const double sigma = std::sqrt(v.dot(local_covariance_.topLeftCorner<3, 3>() * v));
    sigma_m_ = std::min(std::max(sigma_m_, sigma), config_.initial_threshold_m);
  }
  T_O_B_ = found.T_O_B;
  travelled_m_ += step.norm();
  coasted_s_ = 0.0;
  quality_.state = OdometryState::kTracking;
  if (found.localizability.is_degenerate()) {
    quality_.reason_kind = OdometryReason::kDegenerate;
    quality_.reason = "some directions follow the prediction: the surroundings do not show them";
  }
  extend_map();
}

void LidarOdometry::Impl::coast(const Explanation& why, const Prediction& prediction, const Matrix6& predicted) {
  ++counters_.coasted;
  travelled_m_ += (prediction.T_O_B.translation() - T_O_B_.translation()).norm();
  T_O_B_ = prediction.T_O_B;
  local_covariance_ = predicted;
  coasted_s_ += std::min(prediction.dt_s, kMaxScanGap_s);
  velocity_O_ *= std::exp(-prediction.dt_s / config_.coast_velocity_decay_s);
  sigma_m_ = std::min(sigma_m_ * 1.5, config_.initial_threshold_m);
  quality_.state = OdometryState::kCoasting;
  std::tie(quality_.reason_kind, quality_.reason) = why;
  if (coasted_s_ < config_.restart_after_s || source_.size() < static_cast<std::size_t>(config_.min_matched_points))
    return;
  // The old surroundings count as lost. The uncertainty that coasting added stays in the covariance for good.
  quality_.reason += "; after " + number(coasted_s_) + " s a new local map begins here";
  ++counters_.map_restarts;
  map_.clear();
  lost_covariance_ += local_covariance_;
  local_covariance_.setZero();
  coasted_s_ = 0.0;
  has_velocity_ = false;
  velocity_O_.setZero();
  extend_map();
}

void LidarOdometry::Impl::extend_map() {
  inserted_.clear();
  const Eigen::Isometry3f T = T_O_B_.cast<float>();
  for (const Vec3f& p : fine_) inserted_.push_back(T * p);
  map_.keep_around(T.translation(), config_.max_range_m * 1.1);
  map_.insert(inserted_);
  if (matcher_) {
    before_ = fine_;
    T_O_before_ = T_O_B_;
  }
  observed_T_O_B_ = T_O_B_;
}

Matrix6 LidarOdometry::Impl::drift_covariance() const {
  const double translation = config_.drift_ratio * travelled_m_;
  const double rotation = kRotationPerTranslationDrift_radpm * translation;
  return diagonal(translation * translation, rotation * rotation);
}

/// The pose as the scan before gives it. Every point counts as if it held one direction, evenly spread: what PCL says
/// of its result has no covariance, and no direction is found to be weak.
RegistrationResult LidarOdometry::Impl::match_scan_before(const Prediction& prediction) {
  RegistrationResult out;
  out.num_points = static_cast<int>(source_.size());
  if (source_.empty() || before_.empty()) return out;
  const ScanMatch match = matcher_->match(source_, before_, T_O_before_.inverse() * prediction.T_O_B);
  out.T_O_B = T_O_before_ * match.T_target_source;
  out.has_converged = match.has_converged;
  out.iterations = match.iterations;
  out.num_matched = out.num_points;
  out.num_inliers = match.num_inliers;
  out.inlier_ratio = static_cast<double>(match.num_inliers) / out.num_points;
  out.residual_m = match.residual_m;
  out.localizability.eigenvalues.fill(1.0 / 3.0);
  const double reach_m = 0.1 * config_.max_range_m;
  out.information = diagonal(match.num_inliers / 3.0, reach_m * reach_m * match.num_inliers / 3.0);
  return out;
}

void LidarOdometry::Impl::locate(const Prediction& prediction) {
  const Matrix6 predicted = predicted_covariance(prediction);
  const PosePrior prior{prediction.T_O_B, predicted.inverse(), sigma_m_,
                        (prediction.T_O_B.linear() * T_B_L_.linear().col(2)).cast<float>()};
  const RegistrationResult found =
      matcher_ ? match_scan_before(prediction) : register_scan(source_, prior, config_, scan_, &map_);
  quality_.inlier_ratio = found.inlier_ratio;
  quality_.residual_m = found.residual_m;
  quality_.iterations = found.iterations;
  quality_.num_points = found.num_points;
  quality_.eigenvalues = found.localizability.eigenvalues;
  quality_.is_degenerate = found.localizability.is_degenerate();
  const Explanation problem = distrust(found, prediction);
  if (problem.first != OdometryReason::kNone) return coast(problem, prediction, predicted);
  const Matrix6 of_scan_before = local_covariance_;
  track(found, prediction, predicted);
  if (matcher_) local_covariance_ += of_scan_before;
}

}  // namespace voxnav::odometry
