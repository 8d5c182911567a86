// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "voxnav/base/clock_watch.hpp"

namespace voxnav::pipeline {

/// A stamp farther behind the newest one than this is on another clock.
constexpr base::StampNs kMaxStampLagNs = 1'000'000'000;

/// Watches the stamps of sweeps as they arrive. A late sweep says nothing about now, and the map has newer ones, or
/// will have: it is left out. So is one on another clock, until those after it confirm that the clock was set anew.
class SweepStamps {
 public:
  /// @param has_poses  sweeps that bring their poses may be any time apart, the others are expected to be close
  /// @return why the sweep is left out, a sentence; nothing for one that is not
  std::optional<std::string> refuse(base::StampNs start_ns, bool has_poses);

 private:
  static constexpr base::StampNs kMaxLeadNs = 10'000'000'000;

  base::ClockWatch posed_ = base::ClockWatch({kMaxStampLagNs, std::nullopt, 3});
  base::ClockWatch others_ = base::ClockWatch({kMaxStampLagNs, kMaxLeadNs, 3});
};

}  // namespace voxnav::pipeline
