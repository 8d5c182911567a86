// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/odometry/lidar_odometry.hpp"

#include <cmath>
#include <stdexcept>

#include "odometry/lidar_odometry_impl.hpp"

namespace voxnav::odometry {
namespace {

using geometry::Pose;
using geometry::Vec3;

/// A fall of the stamps by more than this is another clock, not a late message.
constexpr base::StampNs kClockJumpNs = 1'000'000'000;
PointMapOptions map_options(const LidarOdometryConfig& c) {
  return {c.voxel_size_m, c.max_points_per_voxel, c.max_map_voxels};
}

/// A stamp farther ahead than this is not believed at once.
constexpr base::StampNs kMaxLeadNs = 10'000'000'000;
constexpr int kNumConfirming = 3;

base::ClockWatch::Limits stamp_limits(StampChecks checks) {
  if (checks == StampChecks::kByCaller) return {kClockJumpNs, std::nullopt, 1};
  return {kClockJumpNs, kMaxLeadNs, kNumConfirming};
}

}  // namespace

LidarOdometry::Impl::Impl(const LidarOdometryConfig& config, const Pose& T_B_L, StampChecks checks)
    : config_(config),
      T_B_L_(T_B_L),
      map_(map_options(config)),
      matcher_(make_scan_matcher(config)),
      clock_(stamp_limits(checks)),
      sigma_m_(config.initial_threshold_m) {}

bool LidarOdometry::Impl::add_imu(const ImuSample& sample) {
  ++counters_.imu_samples;
  const ImuBuffer::AddResult result = imu_.add(sample);
  if (result == ImuBuffer::AddResult::kAdded) return true;
  if (result == ImuBuffer::AddResult::kNotFinite) ++counters_.imu_not_finite;
  const bool is_new_clock = result == ImuBuffer::AddResult::kAddedOnNewClock;
  is_new_clock ? ++counters_.imu_clock_jumps : ++counters_.imu_refused;
  return is_new_clock;
}

void LidarOdometry::Impl::reset(const Pose& T_O_B) {
  map_.clear();
  before_.clear();
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
  clock_.reset();
  gravity_.clear();
  is_level_ = false;
}

bool LidarOdometry::Impl::refuse_time(base::StampNs stamp_ns, OdometryResult* refused) {
  const base::StampVerdict verdict = clock_.add(stamp_ns);
  if (verdict == base::StampVerdict::kNext) return false;
  if (verdict == base::StampVerdict::kNewClock) {
    if (stamp_ns < last_.stamp_ns) follow_new_clock();
    return false;
  }
  ++counters_.clouds_refused;
  *refused = last_;
  refused->is_new = false;
  const bool is_stray = verdict == base::StampVerdict::kStray;
  refused->quality.reason_kind = is_stray ? OdometryReason::kStrayStamp : OdometryReason::kOldStamp;
  refused->quality.reason = is_stray ? "cloud refused: its stamp is on another clock than those before"
                                     : "cloud refused: its stamp is not newer than the previous one";
  return true;
}

/// The new clock does not tell how much time has passed, so that the pose stays and the motion is unknown.
void LidarOdometry::Impl::follow_new_clock() {
  ++counters_.clock_jumps;
  imu_.clear();
  has_velocity_ = has_time_ = false;
  observed_T_O_B_.reset();
  velocity_O_.setZero();
  angular_velocity_B_.setZero();
  sigma_m_ = config_.initial_threshold_m;
}

/// Before the first cloud: takes roll and pitch from the IMU if the specific force is that of a vehicle at rest or in
/// hover.
void LidarOdometry::Impl::begin(base::StampNs start_ns, base::StampNs end_ns) {
  if (!config_.use_imu) return;
  const auto force = imu_.mean_force(start_ns - kClockJumpNs, end_ns);
  const auto up_B = force ? Gravity::up_at_rest(*force) : std::nullopt;
  if (!up_B) return;
  T_O_B_.linear() = Eigen::AngleAxisd(geometry::yaw_of(T_O_B_), Vec3::UnitZ()) * levelling(*up_B);
  is_level_ = true;
}

void LidarOdometry::Impl::fill_result(const Sweep& sweep, bool has_imu) {
  // The pose is estimated for the middle of the sweep and reported for its start, at the stamp of the cloud.
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

void LidarOdometry::Impl::begin_map() {
  if (source_.size() < static_cast<std::size_t>(config_.min_matched_points)) {
    quality_.reason_kind = OdometryReason::kTooFewPoints;
    quality_.reason = "only " + std::to_string(source_.size()) + " points to begin a map with";
    return;
  }
  quality_.reason_kind = OdometryReason::kFirstScan;
  quality_.reason = "first scan";
  extend_map();
}

OdometryResult LidarOdometry::Impl::add_cloud(base::StampNs stamp_ns, const std::vector<Vec3f>& points_L,
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
  const Motion before = motion();
  map_.empty() ? begin_map() : locate(prediction);
  weigh_gravity(before, sweep.middle_ns);
  stamp_ns_ = sweep.middle_ns;
  has_time_ = true;
  imu_.forget_before(stamp_ns - kClockJumpNs);
  fill_result(sweep, prediction.has_imu);
  return last_;
}

std::size_t LidarOdometry::Impl::memory_bytes() const {
  const std::size_t buffers =
      deskewed_.capacity() + fine_.capacity() + source_.capacity() + inserted_.capacity() + before_.capacity();
  return map_.memory_bytes() + buffers * sizeof(Vec3f) + imu_.size() * sizeof(ImuSample);
}

LidarOdometry::LidarOdometry(const LidarOdometryConfig& config, const Pose& T_B_L, StampChecks checks)
    : impl_(std::make_unique<Impl>(base::checked(config), T_B_L, checks)) {}
LidarOdometry::~LidarOdometry() = default;
LidarOdometry::LidarOdometry(LidarOdometry&&) noexcept = default;
LidarOdometry& LidarOdometry::operator=(LidarOdometry&&) noexcept = default;

bool LidarOdometry::add_imu(const ImuSample& sample) { return impl_->add_imu(sample); }
OdometryResult LidarOdometry::add_cloud(base::StampNs stamp_ns, const std::vector<Vec3f>& points_L,
                                        const std::vector<float>& times_s) {
  return impl_->add_cloud(stamp_ns, points_L, times_s);
}
OdometryResult LidarOdometry::add_sweep(const cloud::Sweep& sweep) {
  std::vector<float> times_s;
  times_s.reserve(sweep.time_offsets_ns.size());
  for (const std::uint32_t offset : sweep.time_offsets_ns) times_s.push_back(static_cast<float>(offset) * 1e-9F);
  return add_cloud(sweep.start_ns, sweep.points, times_s);
}
bool LidarOdometry::is_level() const { return impl_->is_level(); }
std::optional<Pose> LidarOdometry::level(bool is_end) { return impl_->level(is_end); }
std::optional<double> LidarOdometry::tilt_rad() const { return impl_->tilt_rad(); }
std::vector<std::string> LidarOdometry::problems() const { return impl_->problems(); }
const base::StampCounts& LidarOdometry::imu_stamps() const { return impl_->imu_stamps(); }
void LidarOdometry::reset(const Pose& T_O_B) { impl_->reset(T_O_B); }
const OdometryCounters& LidarOdometry::counters() const { return impl_->counters(); }
const OdometryResult& LidarOdometry::last() const { return impl_->last(); }
std::size_t LidarOdometry::num_map_points() const { return impl_->map().num_points(); }
std::size_t LidarOdometry::num_map_voxels() const { return impl_->map().num_voxels(); }
std::size_t LidarOdometry::memory_bytes() const { return impl_->memory_bytes(); }

}  // namespace voxnav::odometry
