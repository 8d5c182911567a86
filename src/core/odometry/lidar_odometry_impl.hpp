// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "odometry/imu_buffer.hpp"
#include "odometry/localizability.hpp"
#include "odometry/point_map.hpp"
#include "odometry/registration.hpp"
#include "odometry/scan_matcher.hpp"
#include "voxnav/odometry/lidar_odometry.hpp"

namespace voxnav::odometry {

/// The state of LidarOdometry between clouds, and the steps of one cloud.
class LidarOdometry::Impl {
 public:
  Impl(const LidarOdometryConfig& config, const geometry::Pose& T_B_L, StampChecks checks);

  bool add_imu(const ImuSample& sample);
  OdometryResult add_cloud(base::StampNs stamp_ns, const std::vector<geometry::Vec3f>& points_L,
                           const std::vector<float>& times_s);
  void reset(const geometry::Pose& T_O_B);
  bool is_level() const { return is_level_; }
  std::optional<geometry::Pose> level(bool is_end);
  std::optional<double> tilt_rad() const;
  std::vector<std::string> problems() const;
  const base::StampCounts& imu_stamps() const { return imu_.stamp_counts(); }
  const OdometryCounters& counters() const { return counters_; }
  const OdometryResult& last() const { return last_; }
  const PointMap& map() const { return map_; }
  std::size_t memory_bytes() const;

 private:
  struct Prediction {
    geometry::Pose T_O_B = geometry::Pose::Identity();
    double dt_s = 0.0;
    bool has_imu = false;
  };
  /// The pose is estimated for the middle of a sweep, since an error of the velocity that deskews its points cancels
  /// there. At the start or the end of the sweep it would enter the next velocity, and the error would build up.
  struct Sweep {
    base::StampNs start_ns, middle_ns;
    double duration_s;
  };
  /// The motion at an earlier cloud.
  struct Motion {
    base::StampNs stamp_ns;
    geometry::Pose T_O_B;
    geometry::Vec3 velocity_O;
    bool is_known;
  };
  Motion motion() const { return {stamp_ns_, T_O_B_, velocity_O_, has_time_ && has_velocity_}; }
  static Sweep sweep_of(base::StampNs stamp_ns, const std::vector<float>& times_s);
  std::vector<Eigen::Isometry3f> poses_within(const Sweep& sweep, const Prediction& prediction) const;
  /// Returns true if a cloud cannot be used because of its stamp; `refused` then receives the result of add_cloud().
  bool refuse_time(base::StampNs stamp_ns, OdometryResult* refused);
  void follow_new_clock();
  void begin(base::StampNs start_ns, base::StampNs end_ns);
  void weigh_gravity(const Motion& before, base::StampNs now_ns);
  Prediction predict(base::StampNs stamp_ns) const;
  Eigen::Matrix3d rotation_from(base::StampNs stamp_ns, double t_s, bool has_imu) const;
  void prepare_points(const Sweep& sweep, const std::vector<geometry::Vec3f>& points_L,
                      const std::vector<float>& times_s, const Prediction& prediction);
  Matrix6 predicted_covariance(const Prediction& prediction) const;
  /// Tells why a registration is not trusted, as a reason and its sentence; kNone if it is trusted.
  using Explanation = std::pair<OdometryReason, std::string>;
  Explanation distrust(const RegistrationResult& found, const Prediction& prediction) const;
  void track(const RegistrationResult& found, const Prediction& prediction, const Matrix6& predicted_covariance);
  void begin_map();
  void locate(const Prediction& prediction);
  RegistrationResult match_scan_before(const Prediction& prediction);
  void coast(const Explanation& why, const Prediction& prediction, const Matrix6& predicted_covariance);
  void measure_velocity(const geometry::Pose& found, double dt_s);
  void adapt_threshold(const geometry::Pose& predicted, const geometry::Pose& found);
  void adapt_gyro_bias(const RegistrationResult& found, const Prediction& prediction);
  void extend_map();
  Matrix6 drift_covariance() const;
  void fill_result(const Sweep& sweep, bool has_imu);

  LidarOdometryConfig config_;
  geometry::Pose T_B_L_;
  PointMap map_;
  std::unique_ptr<ScanMatcher> matcher_;  // only where scans are registered to the scan before instead of the map
  Downsampler downsampler_;
  ImuBuffer imu_;
  base::ClockWatch clock_;  // of the clouds
  Gravity gravity_;
  bool is_level_ = false;
  // Points of the present cloud: deskewed, thinned out for the map, thinned out for registration (all in frame B), and
  // as they enter the map (frame O).
  std::vector<geometry::Vec3f> deskewed_, fine_, source_, inserted_;
  std::vector<geometry::Vec3f> before_;  // fine_ of the last scan that was located; empty unless there is a matcher
  geometry::Pose T_O_before_ = geometry::Pose::Identity();

  geometry::Pose T_O_B_ = geometry::Pose::Identity();
  std::optional<geometry::Pose> observed_T_O_B_;  // the last pose on the present clock that was not a prediction
  geometry::Vec3 velocity_O_ = geometry::Vec3::Zero();
  geometry::Vec3 angular_velocity_B_ = geometry::Vec3::Zero();
  geometry::Vec3 gyro_bias_ = geometry::Vec3::Zero();
  bool has_velocity_ = false;
  bool has_time_ = false;
  base::StampNs stamp_ns_ = 0;  // of T_O_B_
  double coasted_s_ = 0.0;
  double sigma_m_;
  double travelled_m_ = 0.0;
  std::uint32_t scan_ = 0;
  Matrix6 local_covariance_ = Matrix6::Zero();  // of the pose against the local map
  Matrix6 lost_covariance_ = Matrix6::Zero();   // of the local map against frame O, from all times it began anew
  Quality quality_;
  OdometryCounters counters_;
  OdometryResult last_;
};

}  // namespace voxnav::odometry
