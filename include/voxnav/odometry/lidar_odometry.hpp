// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "odometry/imu_buffer.hpp"
#include "odometry/localizability.hpp"
#include "odometry/point_map.hpp"
#include "odometry/registration.hpp"
#include "voxnav/cloud/sweep.hpp"
#include "voxnav/odometry/lidar_odometry_config.hpp"

namespace voxnav::odometry {

enum class State : std::uint8_t { kInitializing = 0, kTracking = 1, kCoasting = 2 };
constexpr auto words_of(State) { return std::array{"initializing", "tracking", "coasting"}; }
/// Why the state is what it is.
enum class Reason : std::uint8_t {
  kNone,          ///< it tracks in all directions
  kFirstScan,     ///< the map begins with this scan
  kTooFewPoints,  ///< to begin a map with
  kDegenerate,    ///< it tracks, and some directions follow the prediction
  kFewMatches,    ///< all from here on: the registration is not trusted
  kFewInliers,
  kNotConverged,
  kMovedTooFar,
  kTurnedTooFar,
  kOldStamp,  ///< the cloud was refused
};
constexpr auto words_of(Reason) {
  return std::array{"none",        "first_scan",    "too_few_points", "degenerate",     "few_matches",
                    "few_inliers", "not_converged", "moved_too_far",  "turned_too_far", "old_stamp"};
}

struct Quality {
  State state = State::kInitializing;
  Reason reason_kind = Reason::kNone;
  std::string reason;  ///< the same as a sentence; empty for kNone
  double inlier_ratio = 0.0;
  double residual_m = 0.0;
  int iterations = 0;
  int num_points = 0;
  std::array<double, 6> eigenvalues{};  ///< see Localizability
  bool is_degenerate = false;
};

struct OdometryResult {
  bool is_new = false;  ///< false: the cloud was refused (see quality.reason) and the pose is the previous one
  base::StampNs stamp_ns = 0;
  geometry::Pose T_O_B = geometry::Pose::Identity();           ///< at the stamp, that is at the start of the sweep
  Matrix6 covariance = Matrix6::Zero();                        ///< translation, rotation; axes of O
  geometry::Vec3 velocity_B = geometry::Vec3::Zero();          ///< m/s, axes of B
  geometry::Vec3 angular_velocity_B = geometry::Vec3::Zero();  ///< rad/s, axes of B
  Quality quality;
};

struct OdometryCounters {
  std::uint64_t clouds = 0, clouds_refused = 0, coasted = 0, map_restarts = 0, clock_jumps = 0;
  std::uint64_t points_refused = 0, imu_samples = 0, imu_refused = 0, imu_clock_jumps = 0;
  std::uint64_t scans_without_imu = 0;
};

/// LiDAR-inertial odometry: each scan is deskewed, registered against a bounded local map and added to it.
/// Frame O starts at the first body position, upright when the IMU shows where up is, heading zero.
/// When registration cannot be trusted the pose follows the prediction, the covariance grows and the state says so;
/// the pose never jumps to where nothing is known. Not thread-safe; deterministic.
class LidarOdometry {
 public:
  /// @param T_B_L  LiDAR in the body; IMU samples are in the axes of B
  /// @throws base::ConfigError
  explicit LidarOdometry(const LidarOdometryConfig& config, const geometry::Pose& T_B_L = geometry::Pose::Identity());

  /// A sample that is not finite, late, or alone on another clock is refused and counted.
  void add_imu(const ImuSample& sample);

  /// @param stamp_ns  start of the sweep; must grow (a fall of more than a second is taken as a new clock)
  /// @param points_L  frame L, not deskewed; not finite ones are dropped and counted
  /// @param times_s   per point, after the stamp; empty = all taken at the stamp
  /// @throws std::invalid_argument when times_s has another length than points_L
  /// O(points + iterations * max_source_points)
  OdometryResult add_cloud(base::StampNs stamp_ns, const std::vector<geometry::Vec3f>& points_L,
                           const std::vector<float>& times_s = {});

  OdometryResult add_sweep(const cloud::Sweep& sweep);

  /// Forgets map, motion and IMU; the next cloud starts at T_O_B.
  void reset(const geometry::Pose& T_O_B = geometry::Pose::Identity());

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
  /// The pose is estimated for the middle of a sweep: there, errors of the velocity that deskews cancel. At its
  /// start or end they would enter the next velocity and swing up.
  struct Sweep {
    base::StampNs start_ns, middle_ns;
    double duration_s;
  };
  static Sweep sweep_of(base::StampNs stamp_ns, const std::vector<float>& times_s);
  std::vector<Eigen::Isometry3f> poses_within(const Sweep& sweep, const Prediction& prediction) const;
  /// Result for a cloud that cannot be used at all, or nothing.
  bool refuse_time(base::StampNs stamp_ns, OdometryResult* refused);
  void begin(base::StampNs start_ns, base::StampNs end_ns);
  Prediction predict(base::StampNs stamp_ns) const;
  Eigen::Matrix3d rotation_from(base::StampNs stamp_ns, double t_s, bool has_imu) const;
  void prepare_points(const Sweep& sweep, const std::vector<geometry::Vec3f>& points_L,
                      const std::vector<float>& times_s, const Prediction& prediction);
  Matrix6 predicted_covariance(const Prediction& prediction) const;
  /// Why a registration is not to be trusted, as a reason and its sentence.
  using Explanation = std::pair<Reason, std::string>;
  Explanation distrust(const RegistrationResult& found, const Prediction& prediction) const;
  void track(const RegistrationResult& found, const Prediction& prediction, const Matrix6& predicted_covariance);
  void begin_map();
  void locate(const Prediction& prediction);
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
  Downsampler downsampler_;
  ImuBuffer imu_;
  std::vector<geometry::Vec3f> deskewed_, fine_, source_, inserted_;  // frame B, B, B, O

  geometry::Pose T_O_B_ = geometry::Pose::Identity();
  std::optional<geometry::Pose> observed_T_O_B_;  // the last one that is not a prediction, on the clock in use
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
  Matrix6 local_covariance_ = Matrix6::Zero();  // against the local map
  Matrix6 lost_covariance_ = Matrix6::Zero();   // what the map restarts cost
  Quality quality_;
  OdometryCounters counters_;
  OdometryResult last_;
};

}  // namespace voxnav::odometry
