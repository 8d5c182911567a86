// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "voxnav/base/time.hpp"

namespace voxnav::base {

/// Tells stamps that are late or mistaken, a few at a time, from a clock that was set anew for good. Stamps that come
/// from one source are given to it in the order of their arrival.
class ClockWatch {
 public:
  struct Limits {
    /// A stamp that falls behind the newest one by more than this is not merely late.
    StampNs max_lag_ns = 1'000'000'000;
    /// A stamp farther ahead than this is not believed at once; without a limit every stamp ahead is.
    std::optional<StampNs> max_lead_ns;
    /// So many stamps in a row on another clock, rising and no farther apart than max_lag_ns, make it the clock.
    int num_confirming = 3;
  };

  enum class Verdict {
    kNext,      ///< it follows the ones before
    kLate,      ///< not newer than the newest one; time has not changed
    kStray,     ///< on another clock, which nothing confirms yet
    kNewClock,  ///< the last of enough stamps on another clock: time goes on from this one
  };

  explicit ClockWatch(const Limits& limits) : limits_(limits) {}

  Verdict add(StampNs stamp_ns);
  void reset() { newest_ns_ = stray_ns_ = std::nullopt; }
  /// The newest stamp of the clock that is believed; nothing before the first.
  const std::optional<StampNs>& newest_ns() const { return newest_ns_; }

 private:
  Verdict add_stray(StampNs stamp_ns);

  Limits limits_;
  std::optional<StampNs> newest_ns_;
  std::optional<StampNs> stray_ns_;  // the last stamp on another clock
  int num_stray_ = 0;
};

}  // namespace voxnav::base
