// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "voxnav/base/clock_watch.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::geometry {

/// The newest poses of a moving frame, between which others are interpolated. Bounded; the oldest go first.
class PoseBuffer {
 public:
  static constexpr std::size_t kMaxPoses = 5000;

  /// Takes a pose that is newer than the last one. Late ones, and one alone on another clock, are refused. After a
  /// lasting jump of the clock the poses that showed the jump count too, and those from the same time on are forgotten.
  /// @return false when it was refused, at least for now, or is not a rigid transform
  bool add(base::StampNs stamp_ns, const Pose& pose);
  void clear();
  /// Poses farther apart than this do not tell where the frame was between them; without a limit all do.
  void set_max_gap_ns(std::optional<base::StampNs> max_gap_ns) { max_gap_ns_ = max_gap_ns; }
  /// Gives all poses in another frame. O(poses).
  void move_frame(const Pose& T_new_old);

  /// The pose at a stamp; nothing outside of the time that is covered, or within a gap. O(log n).
  std::optional<Pose> at(base::StampNs stamp_ns) const;
  /// How far the two poses around a stamp are apart, if that is too far; then no later one will ever tell. O(log n).
  std::optional<base::StampNs> gap_around(base::StampNs stamp_ns) const;
  /// Returns true if a stamp lies before the oldest pose, so that no later pose can make it known.
  bool is_before_all(base::StampNs stamp_ns) const;
  bool empty() const { return poses_.empty(); }

 private:
  /// A gap longer than this shows in the stamps as a jump, and is confirmed by the poses after it.
  static constexpr base::StampNs kMaxLeadNs = 1'000'000'000;
  static constexpr base::ClockWatch::Limits kLimits{kMaxLeadNs, kMaxLeadNs, 3};

  void push(const StampedPose& pose);
  void take_strays();
  std::deque<StampedPose>::const_iterator not_before(base::StampNs stamp_ns) const;

  std::deque<StampedPose> poses_;
  std::vector<StampedPose> strays_;  // the newest that are alone on another clock; fewer than confirm it
  base::ClockWatch clock_ = base::ClockWatch(kLimits);
  std::optional<base::StampNs> max_gap_ns_;
};

}  // namespace voxnav::geometry
