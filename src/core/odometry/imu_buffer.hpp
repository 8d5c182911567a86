// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "base/clock_watch.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::odometry {

struct ImuSample {
  base::StampNs stamp_ns = 0;
  geometry::Vec3 gyro_radps = geometry::Vec3::Zero();  ///< body frame B
  geometry::Vec3 accel_mps2 = geometry::Vec3::Zero();  ///< specific force: +g on the axis that points up at rest
};

/// The last seconds of IMU data, bounded. Not thread-safe.
/// A sample whose stamp is far from the others is refused, so that one with a broken stamp does not make all later ones
/// look old. When the samples after it confirm its time, the clock was set anew: those of the old clock are forgotten.
class ImuBuffer {
 public:
  static constexpr std::size_t kMaxSamples = 8000;
  /// A step of the stamps by more than this is a broken stamp or another clock.
  static constexpr base::StampNs kMaxStampStepNs = 1'000'000'000;
  /// So many samples in a row make another clock the one to follow: 25 ms at 200 Hz.
  static constexpr int kNumConfirming = 5;

  enum class AddResult { kAdded, kAddedOnNewClock, kNotFinite, kNotNewer, kOtherClock };
  AddResult add(const ImuSample& sample);
  void clear();
  void forget_before(base::StampNs stamp_ns);
  bool empty() const { return samples_.empty(); }
  std::size_t size() const { return samples_.size(); }
  base::StampNs newest_ns() const { return samples_.back().stamp_ns; }

  /// Rotation of the body from `from_ns` to `to_ns`: coordinates at `to` into coordinates at `from`.
  /// Nothing when the samples leave a gap longer than max_gap_s anywhere in between.
  std::optional<Eigen::Quaterniond> rotation(base::StampNs from_ns, base::StampNs to_ns,
                                             const geometry::Vec3& bias_radps, double max_gap_s) const;
  /// Mean specific force over a time span; nothing without samples in it.
  std::optional<geometry::Vec3> mean_acceleration(base::StampNs from_ns, base::StampNs to_ns) const;

 private:
  std::deque<ImuSample> samples_;
  base::ClockWatch clock_ = base::ClockWatch({kMaxStampStepNs, kMaxStampStepNs, kNumConfirming});
};

/// exp and log of SO(3), rotation vectors in rad.
Eigen::Quaterniond exp_so3(const geometry::Vec3& rotation);
geometry::Vec3 log_so3(const Eigen::Quaterniond& q);

}  // namespace voxnav::odometry
