// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/odometry/lidar_odometry.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "odometry_limits.hpp"

namespace voxnav::odometry {
namespace {

using geometry::Pose;
using geometry::Vec3;

constexpr double kGravity_mps2 = 9.81;
/// A fall of the stamps by more than this is another clock, not a late message.
constexpr base::StampNs kClockJumpNs = 1'000'000'000;
constexpr double kBiasGain = 0.02;
constexpr double kMaxBias_radps = 0.2;
/// Rotation drift per position drift: a degree on a hundred metres goes with the default ratio.
constexpr double kRotationPerTranslationDrift_radpm = 0.04;

std::string number(double value) {
  const std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 3);
}

PointMapOptions map_options(const LidarOdometryConfig& c) {
  return {c.voxel_size_m, c.max_points_per_voxel, c.max_map_voxels};
}

Matrix6 diagonal(double translation_var, double rotation_var) {
  Vector6 d;
  d << Vec3::Constant(translation_var), Vec3::Constant(rotation_var);
  return d.asDiagonal();
}

/// Upright attitude with heading zero from the direction of the specific force at rest.
Pose upright(const Vec3& specific_force) {
  Pose pose = Pose::Identity();
  const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(specific_force, Vec3::UnitZ());
  const Eigen::AngleAxisd unturn(-geometry::yaw_of(Pose(q)), Vec3::UnitZ());
  pose.linear() = (unturn * q).toRotationMatrix();
  return pose;
}

}  // namespace

LidarOdometry::LidarOdometry(const LidarOdometryConfig& config, const Pose& T_B_L)
    : config_(base::checked(config)), T_B_L_(T_B_L), map_(map_options(config)), sigma_m_(config.initial_threshold_m) {}

void LidarOdometry::add_imu(const ImuSample& sample) {
  ++counters_.imu_samples;
  const ImuBuffer::AddResult result = imu_.add(sample);
  if (result == ImuBuffer::AddResult::kAdded) return;
  result == ImuBuffer::AddResult::kAddedOnNewClock ? ++counters_.imu_clock_jumps : ++counters_.imu_refused;
}

void LidarOdometry::reset(const Pose& T_O_B) {
  map_.clear();
  imu_.clear();
  T_O_B_ = T_O_B;
  velocity_O_.setZero();
  angular_velocity_B_.setZero();
  gyro_bias_.setZero();
  has_velocity_ = has_time_ = false;
  observed_T_O_B_.reset();
  coasted_s_ = travelled_m_ = 0.0;
  sigma_m_ = config_.initial_threshold_m;
  local_covariance_.setZero();
  lost_covariance_.setZero();
  quality_ = Quality();
  last_ = OdometryResult();
}

bool LidarOdometry::refuse_time(base::StampNs stamp_ns, OdometryResult* refused) {
  if (!has_time_ || stamp_ns > last_.stamp_ns) return false;
  if (last_.stamp_ns - stamp_ns > kClockJumpNs) {
    // The new clock says nothing about the time that passed: position stays, motion is unknown.
    ++counters_.clock_jumps;
    imu_.clear();
    has_velocity_ = has_time_ = false;
    observed_T_O_B_.reset();
    velocity_O_.setZero();
    angular_velocity_B_.setZero();
    sigma_m_ = config_.initial_threshold_m;
    return false;
  }
  ++counters_.clouds_refused;
  *refused = last_;
  refused->is_new = false;
  refused->quality.reason_kind = Reason::kOldStamp;
  refused->quality.reason = "cloud refused: its stamp is not newer than the previous one";
  return true;
}

/// First cloud: the attitude against gravity from the IMU, where it is at rest or hovering.
void LidarOdometry::begin(base::StampNs start_ns, base::StampNs end_ns) {
  if (!config_.use_imu) return;
  const auto force = imu_.mean_acceleration(start_ns - kClockJumpNs, end_ns);
  if (!force || std::abs(force->norm() - kGravity_mps2) > 1.5) return;
  const Pose level = upright(*force);
  T_O_B_.linear() = Eigen::AngleAxisd(geometry::yaw_of(T_O_B_), Vec3::UnitZ()) * level.linear();
}

Matrix6 LidarOdometry::predicted_covariance(const Prediction& prediction) const {
  const double span = prediction.dt_s + coasted_s_;
  const double acceleration_m = 0.5 * config_.acceleration_noise_mps2 * (span * span - coasted_s_ * coasted_s_);
  const double unknown_m = has_velocity_ ? 0.0 : 0.5 * config_.max_speed_mps * prediction.dt_s;
  const double rotation =
      (prediction.has_imu ? config_.gyro_noise_radps : 1.0) * std::min(prediction.dt_s, kMaxScanGap_s);
  const double velocity_m = config_.velocity_noise_mps * prediction.dt_s;
  const double translation_var = acceleration_m * acceleration_m + velocity_m * velocity_m + unknown_m * unknown_m;
  return local_covariance_ + diagonal(translation_var, rotation * rotation + 1e-8);
}

LidarOdometry::Explanation LidarOdometry::distrust(const RegistrationResult& found,
                                                   const Prediction& prediction) const {
  if (found.num_matched < config_.min_matched_points) {
    return {Reason::kFewMatches, "only " + std::to_string(found.num_matched) + " of " +
                                     std::to_string(found.num_points) + " points match the map"};
  }
  if (found.inlier_ratio < config_.min_inlier_ratio) {
    return {Reason::kFewInliers, "inlier ratio is only " + number(found.inlier_ratio)};
  }
  if (!found.has_converged) return {Reason::kNotConverged, "registration did not converge"};
  const double span = prediction.dt_s + coasted_s_;
  const double moved = (found.T_O_B.translation() - prediction.T_O_B.translation()).norm();
  const double reach = has_velocity_ ? config_.max_acceleration_mps2 * span * span : config_.max_speed_mps * span;
  if (moved > 0.3 + reach) {
    return {Reason::kMovedTooFar, "registration moved the pose by " + number(moved) + " m, more than motion allows"};
  }
  const double turned = Eigen::AngleAxisd(found.T_O_B.linear().transpose() * prediction.T_O_B.linear()).angle();
  const double turn_reach = prediction.has_imu ? 0.1 + 0.2 * span : 0.5 + span;
  if (turned > turn_reach) {
    return {Reason::kTurnedTooFar,
            "registration turned the pose by " + number(turned) + " rad, more than motion allows"};
  }
  return {Reason::kNone, ""};
}

void LidarOdometry::adapt_threshold(const Pose& predicted, const Pose& found) {
  const Pose error = predicted.inverse() * found;
  const double angle = Eigen::AngleAxisd(error.linear()).angle();
  const double deviation = error.translation().norm() + 2.0 * config_.max_range_m * 0.5 * std::sin(angle / 2.0);
  // A mean that forgets, so that one rough moment does not widen the gate for the rest of the flight.
  sigma_m_ = std::sqrt(0.7 * sigma_m_ * sigma_m_ + 0.3 * deviation * deviation);
  sigma_m_ = std::min(std::max(sigma_m_, config_.min_threshold_m / 3.0), config_.initial_threshold_m);
}

void LidarOdometry::adapt_gyro_bias(const RegistrationResult& found, const Prediction& prediction) {
  if (!prediction.has_imu || !has_time_ || prediction.dt_s <= 0 || !found.localizability.weak_rotations.empty()) return;
  const Eigen::Quaterniond error(prediction.T_O_B.linear().transpose() * found.T_O_B.linear());
  gyro_bias_ -= kBiasGain * log_so3(error) / prediction.dt_s;
  gyro_bias_ = gyro_bias_.cwiseMin(kMaxBias_radps).cwiseMax(-kMaxBias_radps);
}

/// The mean velocity since a pose was last observed: a coast of a few scans leaves the velocity known.
void LidarOdometry::measure_velocity(const Pose& found, double dt_s) {
  const double span_s = dt_s + coasted_s_;
  has_velocity_ = observed_T_O_B_ && dt_s > 0.0 && span_s <= kMaxScanGap_s;
  if (has_velocity_) {
    velocity_O_ = (found.translation() - observed_T_O_B_->translation()) / span_s;
    angular_velocity_B_ = log_so3(Eigen::Quaterniond(observed_T_O_B_->linear().transpose() * found.linear())) / span_s;
  } else {
    velocity_O_.setZero();
  }
}

void LidarOdometry::track(const RegistrationResult& found, const Prediction& prediction, const Matrix6& predicted) {
  const Vec3 step = found.T_O_B.translation() - T_O_B_.translation();
  adapt_threshold(prediction.T_O_B, found.T_O_B);
  if (coasted_s_ == 0.0) adapt_gyro_bias(found, prediction);
  measure_velocity(found.T_O_B, prediction.dt_s);
  const double noise_var = config_.measurement_noise_m * config_.measurement_noise_m;
  const Matrix6 information = without_weak_directions(found.information, found.localizability) / noise_var;
  local_covariance_ = (predicted.inverse() + information).inverse();
  local_covariance_ = 0.5 * (local_covariance_ + local_covariance_.transpose()).eval();
  // Where the pose only follows the prediction, the gate must stay wide enough to find the surroundings again.
  for (const Vec3& v : found.localizability.weak_translations) {
    const double sigma = std::sqrt(v.dot(local_covariance_.topLeftCorner<3, 3>() * v));
    sigma_m_ = std::min(std::max(sigma_m_, sigma), config_.initial_threshold_m);
  }
  T_O_B_ = found.T_O_B;
  travelled_m_ += step.norm();
  coasted_s_ = 0.0;
  quality_.state = State::kTracking;
  if (found.localizability.is_degenerate()) {
    quality_.reason_kind = Reason::kDegenerate;
    quality_.reason = "some directions follow the prediction: the surroundings do not show them";
  }
  extend_map();
}

void LidarOdometry::coast(const Explanation& why, const Prediction& prediction, const Matrix6& predicted) {
  ++counters_.coasted;
  travelled_m_ += (prediction.T_O_B.translation() - T_O_B_.translation()).norm();
  T_O_B_ = prediction.T_O_B;
  local_covariance_ = predicted;
  coasted_s_ += std::min(prediction.dt_s, kMaxScanGap_s);
  velocity_O_ *= std::exp(-prediction.dt_s / config_.coast_velocity_decay_s);
  sigma_m_ = std::min(sigma_m_ * 1.5, config_.initial_threshold_m);
  quality_.state = State::kCoasting;
  std::tie(quality_.reason_kind, quality_.reason) = why;
  if (coasted_s_ < config_.restart_after_s || source_.size() < static_cast<std::size_t>(config_.min_matched_points))
    return;
  // The old surroundings are lost for good; what the coasting cost stays in the covariance.
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

void LidarOdometry::extend_map() {
  inserted_.clear();
  const Eigen::Isometry3f T = T_O_B_.cast<float>();
  for (const Vec3f& p : fine_) inserted_.push_back(T * p);
  map_.keep_around(T.translation(), config_.max_range_m * 1.1);
  map_.insert(inserted_);
  observed_T_O_B_ = T_O_B_;
}

Matrix6 LidarOdometry::drift_covariance() const {
  const double translation = config_.drift_ratio * travelled_m_;
  const double rotation = kRotationPerTranslationDrift_radpm * translation;
  return diagonal(translation * translation, rotation * rotation);
}

void LidarOdometry::fill_result(const Sweep& sweep, bool has_imu) {
  // The pose is kept for the middle of the sweep and told for its start, where the cloud's stamp is.
  const double back_s = base::to_seconds(sweep.start_ns - sweep.middle_ns);
  last_.is_new = true;
  last_.stamp_ns = sweep.start_ns;
  last_.T_O_B = T_O_B_;
  if (back_s != 0.0) {
    last_.T_O_B.linear() = T_O_B_.linear() * rotation_from(sweep.middle_ns, back_s, has_imu);
    last_.T_O_B.translation() += velocity_O_ * back_s;
  }
  last_.covariance = local_covariance_ + lost_covariance_ + drift_covariance() + diagonal(1e-6, 1e-8);
  last_.velocity_B = T_O_B_.linear().transpose() * velocity_O_;
  last_.angular_velocity_B = angular_velocity_B_;
  last_.quality = quality_;
}

void LidarOdometry::begin_map() {
  if (source_.size() < static_cast<std::size_t>(config_.min_matched_points)) {
    quality_.reason_kind = Reason::kTooFewPoints;
    quality_.reason = "only " + std::to_string(source_.size()) + " points to begin a map with";
    return;
  }
  quality_.reason_kind = Reason::kFirstScan;
  quality_.reason = "first scan";
  extend_map();
}

void LidarOdometry::locate(const Prediction& prediction) {
  const Matrix6 predicted = predicted_covariance(prediction);
  const PosePrior prior{prediction.T_O_B, predicted.inverse(), sigma_m_,
                        (prediction.T_O_B.linear() * T_B_L_.linear().col(2)).cast<float>()};
  const RegistrationResult found = register_scan(source_, prior, config_, scan_, &map_);
  quality_.inlier_ratio = found.inlier_ratio;
  quality_.residual_m = found.residual_m;
  quality_.iterations = found.iterations;
  quality_.num_points = found.num_points;
  quality_.eigenvalues = found.localizability.eigenvalues;
  quality_.is_degenerate = found.localizability.is_degenerate();
  const Explanation problem = distrust(found, prediction);
  problem.first == Reason::kNone ? track(found, prediction, predicted) : coast(problem, prediction, predicted);
}

OdometryResult LidarOdometry::add_sweep(const cloud::Sweep& sweep) {
  std::vector<float> times_s;
  times_s.reserve(sweep.time_offsets_ns.size());
  for (const std::uint32_t offset : sweep.time_offsets_ns) times_s.push_back(static_cast<float>(offset) * 1e-9F);
  return add_cloud(sweep.start_ns, sweep.points, times_s);
}

OdometryResult LidarOdometry::add_cloud(base::StampNs stamp_ns, const std::vector<Vec3f>& points_L,
                                        const std::vector<float>& times_s) {
  if (!times_s.empty() && times_s.size() != points_L.size()) {
    throw std::invalid_argument("point times: " + std::to_string(times_s.size()) + " for " +
                                std::to_string(points_L.size()) + " points");
  }
  OdometryResult refused;
  if (refuse_time(stamp_ns, &refused)) return refused;
  ++counters_.clouds;
  ++scan_;
  const Sweep sweep = sweep_of(stamp_ns, times_s);
  if (map_.empty() && !has_time_) begin(stamp_ns, stamp_ns + base::from_seconds(sweep.duration_s));
  const Prediction prediction = predict(sweep.middle_ns);
  if (config_.use_imu && !prediction.has_imu) ++counters_.scans_without_imu;
  prepare_points(sweep, points_L, times_s, prediction);
  quality_ = Quality();
  map_.empty() ? begin_map() : locate(prediction);
  stamp_ns_ = sweep.middle_ns;
  has_time_ = true;
  imu_.forget_before(stamp_ns - kClockJumpNs);
  fill_result(sweep, prediction.has_imu);
  return last_;
}

std::size_t LidarOdometry::memory_bytes() const {
  const std::size_t buffers = deskewed_.capacity() + fine_.capacity() + source_.capacity() + inserted_.capacity();
  return map_.memory_bytes() + buffers * sizeof(Vec3f) + imu_.size() * sizeof(ImuSample);
}

}  // namespace voxnav::odometry
