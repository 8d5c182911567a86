// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "odometry/gravity.hpp"
#include "voxnav/base/clock_watch.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/odometry/lidar_odometry.hpp"

namespace voxnav::odometry {

/// A bounded buffer of the last seconds of IMU data. Not thread-safe.
/// A sample whose stamp is far from the others is refused, so that one with a broken stamp does not make all later ones
/// look old. When the samples after it confirm its time, the clock was set anew, and those of the old clock are
/// forgotten.
class ImuBuffer {
 public:
  static constexpr std::size_t kMaxSamples = 8000;
  /// A stamp that far behind the others is a broken one or on another clock.
  static constexpr base::StampNs kMaxLagNs = 1'000'000'000;
  /// So is one that far ahead. The samples up to it would be taken for late ones if it were believed.
  static constexpr base::StampNs kMaxLeadNs = 200'000'000;
  /// This many samples in a row on another clock (25 ms at 200 Hz) make it the clock to follow.
  static constexpr int kNumConfirming = 5;

  enum class AddResult { kAdded, kAddedOnNewClock, kNotFinite, kNotNewer, kOtherClock };
  AddResult add(const ImuSample& sample);
  void clear();
  void forget_before(base::StampNs stamp_ns);
  bool empty() const { return samples_.empty(); }
  std::size_t size() const { return samples_.size(); }
  base::StampNs newest_ns() const { return samples_.back().stamp_ns; }
  /// What became of the stamps, of all samples that were finite.
  const base::StampCounts& stamp_counts() const { return clock_.counts(); }

  /// Rotation that takes coordinates of the body at `to_ns` to coordinates of the body at `from_ns`. Nothing when the
  /// samples leave a gap longer than max_gap_s anywhere in between.
  std::optional<Eigen::Quaterniond> rotation(base::StampNs from_ns, base::StampNs to_ns,
                                             const geometry::Vec3& bias_radps, double max_gap_s) const;
  /// Returns the mean specific force over a time span; nothing if it contains no samples.
  std::optional<MeanForce> mean_force(base::StampNs from_ns, base::StampNs to_ns) const;

 private:
  std::deque<ImuSample> samples_;
  base::ClockWatch clock_ = base::ClockWatch({kMaxLagNs, kMaxLeadNs, kNumConfirming});
};

/// Exponential map of SO(3) and its inverse; rotation vectors are in rad.
/// Source: Forster et al., On-manifold preintegration, IEEE Transactions on Robotics 2017, section III-A.
Eigen::Quaterniond exp_so3(const geometry::Vec3& rotation);
geometry::Vec3 log_so3(const Eigen::Quaterniond& q);

}  // namespace voxnav::odometry
