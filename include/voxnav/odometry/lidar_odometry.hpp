// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/base/clock_watch.hpp"
#include "voxnav/cloud/sweep.hpp"
#include "voxnav/odometry/lidar_odometry_config.hpp"
#include "voxnav/odometry/odometry_result.hpp"

namespace voxnav::odometry {

/// Who checks whether the stamp of a cloud is wrong or of another clock.
enum class StampChecks : std::uint8_t {
  kOwn,      ///< the odometry, which accepts another clock at its third cloud
  kByCaller  ///< the caller; the odometry takes a step back by more than a second for another clock at once
};

/// LiDAR-inertial odometry: each cloud is deskewed, registered against a bounded local map and added to it.
/// Frame O starts at the first position of the body with heading zero, and level if the IMU shows the vertical. If it
/// shows it later, level() can make the frame level then.
/// If a registration cannot be trusted, the pose follows the prediction, the covariance grows and the state tells it,
/// so that the pose never jumps to a place that no measurement supports. Not thread-safe; deterministic.
/// Source: Vizzo et al., KISS-ICP, RA-L 2023, section III; docs/maths/odometry.md has the formulas and the differences.
class LidarOdometry {
 public:
  /// @param T_B_L  pose of the LiDAR in the body frame, in whose axes IMU samples are given
  /// @throws base::ConfigError
  explicit LidarOdometry(const LidarOdometryConfig& config, const geometry::Pose& T_B_L = geometry::Pose::Identity(),
                         StampChecks checks = StampChecks::kOwn);
  ~LidarOdometry();
  LidarOdometry(LidarOdometry&&) noexcept;
  LidarOdometry& operator=(LidarOdometry&&) noexcept;

  /// Adds a sample. One that is not finite, not newer than the last, or alone on another clock is refused and counted.
  /// @return true if it was accepted
  bool add_imu(const ImuSample& sample);

  /// Finds the pose at which a cloud was taken.
  /// @param stamp_ns  start of the sweep. Stamps must grow: an older one is refused, and so is one that is more than a
  ///                  second older or ten seconds newer, until those after it show that the clock was set anew
  /// @param points_L  points in frame L, not deskewed; those that are not finite are dropped and counted
  /// @param times_s   time of each point after the stamp; empty when all points were taken at the stamp
  /// @throws std::invalid_argument when times_s has another length than points_L
  /// O(points + iterations * max_source_points)
  OdometryResult add_cloud(base::StampNs stamp_ns, const std::vector<geometry::Vec3f>& points_L,
                           const std::vector<float>& times_s = {});

  /// Finds the pose at which a sweep of cloud::read_sweep() was taken, as add_cloud() does.
  OdometryResult add_sweep(const cloud::Sweep& sweep);

  /// Returns true if the z axis of frame O points up according to the IMU.
  bool is_level() const;
  /// Makes frame O level by a rotation about its origin, once IMU and motion since the first cloud show the vertical
  /// (after two seconds of both, or less if `is_end` tells that no more will come).
  /// @return T_new_O, by which the caller transforms what is given in the frame; nothing if the frame is level already
  ///         or the vertical is not known yet
  std::optional<geometry::Pose> level(bool is_end = false);
  /// Returns the angle in rad between the z axis of frame O and the vertical that the IMU shows over the whole flight;
  /// nothing if it does not show it.
  std::optional<double> tilt_rad() const;
  /// The counts of the stamps of IMU samples.
  const base::StampCounts& imu_stamps() const;
  /// Returns what is wrong with the IMU samples and the frame, in sentences for people; empty if nothing is.
  std::vector<std::string> problems() const;

  /// Forgets map, motion and IMU; the next cloud starts at T_O_B.
  void reset(const geometry::Pose& T_O_B = geometry::Pose::Identity());

  const OdometryCounters& counters() const;
  /// The result of the last cloud that was not refused.
  const OdometryResult& last() const;
  /// Points, and voxels, of the map that clouds are registered against.
  std::size_t num_map_points() const;
  std::size_t num_map_voxels() const;
  std::size_t memory_bytes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voxnav::odometry
