// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "voxnav/base/time.hpp"

namespace voxnav::base {

/// The relation of a stamp to the clock of its source.
enum class StampVerdict : std::uint8_t {
  kNext,      ///< it follows the ones before
  kRepeated,  ///< it equals the newest one
  kLate,      ///< it is older than the newest one, and time has not changed
  kStray,     ///< it is on another clock, which is not confirmed yet
  kNewClock,  ///< it is the last of enough stamps on another clock: time goes on from this one
};
constexpr auto words_of(StampVerdict) { return std::array{"next", "repeated", "late", "stray", "new_clock"}; }

/// Counts of the verdicts, and of clocks that stood still.
struct StampCounts {
  std::uint64_t next = 0, repeated = 0, late = 0, stray = 0, new_clocks = 0;
  std::uint64_t stuck_clocks = 0;    ///< times that kNumStuck stamps in a row or more were equal
  std::uint64_t longest_repeat = 0;  ///< most repeated stamps in a row
};

/// Returns all counts except `next` as a phrase for people, such as "2 repeated, 1 alone on another clock"; it is empty
/// if all stamps followed each other.
std::string describe(const StampCounts& counts);

/// Tells a few late or wrong stamps from a clock that was set to another time. The stamps of one source are added in
/// the order of their arrival. Not thread-safe; O(1).
class ClockWatch {
 public:
  /// The number of equal stamps in a row after which the clock counts as stuck.
  static constexpr std::uint64_t kNumStuck = 10;

  struct Limits {
    /// A stamp that falls behind the newest one by more than this is not merely late.
    StampNs max_lag_ns = 1'000'000'000;
    /// A stamp farther ahead than this is not accepted at once; without a limit every stamp ahead is.
    std::optional<StampNs> max_lead_ns;
    /// The number of stamps in a row on another clock that confirm it. They must rise, and be no farther apart than the
    /// greater of the two limits, or than the first of them is ahead.
    int num_confirming = 3;
  };

  explicit ClockWatch(const Limits& limits) : limits_(limits) {}

  StampVerdict add(StampNs stamp_ns);
  /// Forgets the clock; the counts stay.
  void reset();
  /// The newest stamp of the present clock; nothing before the first.
  const std::optional<StampNs>& newest_ns() const { return newest_ns_; }
  const StampCounts& counts() const { return counts_; }
  /// Returns true if the last kNumStuck stamps or more were equal.
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
