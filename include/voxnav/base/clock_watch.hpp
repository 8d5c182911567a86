// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "voxnav/base/time.hpp"

namespace voxnav::base {

/// What a stamp says about the time of its source.
enum class StampVerdict : std::uint8_t {
  kNext,      ///< it follows the ones before
  kRepeated,  ///< it equals the newest one
  kLate,      ///< it is older than the newest one, and time has not changed
  kStray,     ///< it is on another clock, which nothing confirms yet
  kNewClock,  ///< it is the last of enough stamps on another clock: time goes on from this one
};
constexpr auto words_of(StampVerdict) { return std::array{"next", "repeated", "late", "stray", "new_clock"}; }

/// How often each verdict was given, and how often a clock stood still.
struct StampCounts {
  std::uint64_t next = 0, repeated = 0, late = 0, stray = 0, new_clocks = 0;
  std::uint64_t stuck_clocks = 0;    ///< times that kNumStuck stamps in a row or more were equal
  std::uint64_t longest_repeat = 0;  ///< most repeated stamps in a row
};

/// The counts but for `next` as a phrase for people, such as "2 repeated, 1 alone on another clock"; empty when all
/// stamps followed each other.
std::string describe(const StampCounts& counts);

/// Tells stamps that are late or mistaken, a few at a time, from a clock that was set anew for good. Stamps that come
/// from one source are given to it in the order of their arrival. Not thread-safe; O(1).
class ClockWatch {
 public:
  /// This many equal stamps in a row make a stuck clock.
  static constexpr std::uint64_t kNumStuck = 10;

  struct Limits {
    /// A stamp that falls behind the newest one by more than this is not merely late.
    StampNs max_lag_ns = 1'000'000'000;
    /// A stamp farther ahead than this is not believed at once; without a limit every stamp ahead is.
    std::optional<StampNs> max_lead_ns;
    /// So many stamps in a row on another clock, rising and no farther apart than the greater of the two limits (or
    /// than the first of them is ahead), make it the clock.
    int num_confirming = 3;
  };

  explicit ClockWatch(const Limits& limits) : limits_(limits) {}

  StampVerdict add(StampNs stamp_ns);
  /// Forgets the clock; the counts stay.
  void reset();
  /// The newest stamp of the clock that is believed; nothing before the first.
  const std::optional<StampNs>& newest_ns() const { return newest_ns_; }
  const StampCounts& counts() const { return counts_; }
  /// Whether the last kNumStuck stamps or more were equal.
  bool is_stuck() const { return num_equal_ + 1 >= kNumStuck; }

 private:
  StampVerdict judge(StampNs stamp_ns);
  StampVerdict judge_stray(StampNs stamp_ns);
  void note_repeat(bool is_repeated);

  Limits limits_;
  std::optional<StampNs> newest_ns_;
  std::optional<StampNs> stray_ns_;  // the last stamp on another clock
  int num_stray_ = 0;
  std::uint64_t num_equal_ = 0;  // stamps in a row that repeat the one before
  std::optional<StampNs> last_ns_;
  StampCounts counts_;
};

}  // namespace voxnav::base
