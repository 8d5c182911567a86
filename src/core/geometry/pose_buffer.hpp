// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "base/clock_watch.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::geometry {

/// The newest poses of a moving frame, between which others are interpolated. Bounded; the oldest go first.
class PoseBuffer {
 public:
  static constexpr std::size_t kMaxPoses = 5000;

  /// Takes a pose that is newer than the last one. Late ones, and one alone on another clock, are refused; a lasting
  /// jump of the clock forgets those before it.
  /// @return false when it was refused, or is not a rigid transform
  bool add(base::StampNs stamp_ns, const Pose& pose);
  void clear();
  /// Poses farther apart than this do not tell where the frame was between them; without a limit all do.
  void set_max_gap_ns(std::optional<base::StampNs> max_gap_ns) { max_gap_ns_ = max_gap_ns; }

  /// The pose at a stamp; nothing outside of the time that is covered, or within a gap. O(log n).
  std::optional<Pose> at(base::StampNs stamp_ns) const;
  /// How far the two poses around a stamp are apart, if that is too far; then no later one will ever tell. O(log n).
  std::optional<base::StampNs> gap_around(base::StampNs stamp_ns) const;
  /// Returns true if a stamp lies before the oldest pose, so that no later pose can make it known.
  bool is_before_all(base::StampNs stamp_ns) const;
  bool empty() const { return poses_.empty(); }

 private:
  std::deque<StampedPose>::const_iterator not_before(base::StampNs stamp_ns) const;

  std::deque<StampedPose> poses_;
  base::ClockWatch clock_ = base::ClockWatch({});
  std::optional<base::StampNs> max_gap_ns_;
};

}  // namespace voxnav::geometry
