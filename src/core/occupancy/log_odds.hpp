// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/occupancy/local_map_config.hpp"

namespace voxnav::occupancy {

double log_odds_of(double probability);
double probability_of(double log_odds);

/// Quantises log-odds to one byte: level 0 is the lower clamp, level `max` the upper one. The scale is chosen so that
/// the numbers of hits and misses between states equal those of exact arithmetic (see transitions_of()).
struct LogOddsScale {
  double levels_per_unit = 1.0;
  double min_log_odds = 0.0;
  std::uint8_t prior = 0;  ///< level of probability 0.5, where every voxel starts
  std::uint8_t max = 0;
  std::uint8_t hit = 0;   ///< levels added by a hit
  std::uint8_t miss = 0;  ///< levels taken by a miss

  static LogOddsScale from(const LocalMapConfig& config);

  double log_odds(int level) const { return (level - prior) / levels_per_unit; }
  /// The highest level that is strictly below a probability; -1 when there is none.
  int highest_below(double probability) const;
  /// The lowest level that is strictly above a probability; max + 1 when there is none.
  int lowest_above(double probability) const;
};

/// The levels that separate the three states. A voxel at one of the two thresholds is unknown.
struct StateLevels {
  int free_max = -1;       ///< free up to and including this level
  int occupied_min = 256;  ///< occupied from this level on

  StateLevels() = default;
  StateLevels(const LogOddsScale& scale, double free_threshold, double occupied_threshold)
      : free_max(scale.highest_below(free_threshold)), occupied_min(scale.lowest_above(occupied_threshold)) {}
  /// The limits as bytes, as the kernels compare them: a level is free below free_end() and occupied from
  /// occupied_begin() on.
  std::uint8_t free_end() const { return static_cast<std::uint8_t>(free_max + 1); }
  std::uint8_t occupied_begin() const { return static_cast<std::uint8_t>(occupied_min < 255 ? occupied_min : 255); }
  containers::VoxelState of(int level) const {
    if (level >= occupied_min) return containers::VoxelState::kOccupied;
    return level <= free_max ? containers::VoxelState::kFree : containers::VoxelState::kUnknown;
  }
};

/// The number of scans that take a voxel from one state to another; -1 if that state is never reached. "Full" is a
/// voxel at the upper clamp, "empty" one at the lower clamp.
struct Transitions {
  int hits_unknown_to_occupied;
  int misses_unknown_to_free;
  int misses_full_to_not_occupied;
  int misses_full_to_free;
  int hits_empty_to_not_free;
  int hits_empty_to_occupied;
};
/// The transitions in exact arithmetic, which the byte scale has to reproduce.
Transitions ideal_transitions(const LocalMapConfig& config);
Transitions transitions_of(const LogOddsScale& scale, const StateLevels& levels);
/// Returns the sum of the absolute differences of all counts. A byte scale is faithful if its mismatch to the ideal
/// transitions is zero.
int mismatch(const Transitions& a, const Transitions& b);

}  // namespace voxnav::occupancy
