// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/log_odds.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace voxnav::occupancy {
namespace {

// A voxel whose probability equals a threshold is unknown, so a level that equals the threshold up to rounding must not
// count as beyond it.
constexpr double kTieLevels = 1e-6;
constexpr double kTieLogOdds = 1e-9;
constexpr int kMaxLevel = 250;
constexpr int kMaxScans = 1000;

/// Returns how often `step` has to be applied to `start` until `reached` holds.
template <class Number, class Reached>
int count_steps(Number start, Number step, Number low, Number high, Reached reached) {
  Number value = start;
  for (int n = 1; n <= kMaxScans; ++n) {
    const Number next = std::min(high, std::max(low, static_cast<Number>(value + step)));
    if (reached(next)) return n;
    if (next == value) return -1;
    value = next;
  }
  return -1;
}

template <class Number, class Free, class Occupied>
Transitions count_all(Number prior, Number hit, Number miss, Number low, Number high, Free is_free,
                      Occupied is_occupied) {
  const auto not_free = [&](Number v) { return !is_free(v); };
  const auto not_occupied = [&](Number v) { return !is_occupied(v); };
  return {count_steps(prior, hit, low, high, is_occupied),  count_steps(prior, miss, low, high, is_free),
          count_steps(high, miss, low, high, not_occupied), count_steps(high, miss, low, high, is_free),
          count_steps(low, hit, low, high, not_free),       count_steps(low, hit, low, high, is_occupied)};
}

LogOddsScale scale_with_hit(const LocalMapConfig& config, int hit) {
  LogOddsScale scale;
  scale.levels_per_unit = hit / log_odds_of(config.prob_hit);
  scale.min_log_odds = log_odds_of(config.prob_clamp_min);
  const auto levels = [&](double log_odds) { return static_cast<int>(std::lround(log_odds * scale.levels_per_unit)); };
  scale.prior = static_cast<std::uint8_t>(levels(-scale.min_log_odds));
  scale.max = static_cast<std::uint8_t>(scale.prior + levels(log_odds_of(config.prob_clamp_max)));
  scale.hit = static_cast<std::uint8_t>(hit);
  scale.miss = static_cast<std::uint8_t>(std::max(1, levels(-log_odds_of(config.prob_miss))));
  return scale;
}

}  // namespace

double log_odds_of(double probability) { return std::log(probability / (1.0 - probability)); }
double probability_of(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

int LogOddsScale::highest_below(double probability) const {
  const double level = prior + log_odds_of(probability) * levels_per_unit;
  return static_cast<int>(std::clamp(std::ceil(level - kTieLevels) - 1.0, -1.0, static_cast<double>(max)));
}

int LogOddsScale::lowest_above(double probability) const {
  const double level = prior + log_odds_of(probability) * levels_per_unit;
  return static_cast<int>(std::clamp(std::floor(level + kTieLevels) + 1.0, 0.0, max + 1.0));
}

Transitions ideal_transitions(const LocalMapConfig& config) {
  const double free_limit = log_odds_of(config.free_threshold) - kTieLogOdds;
  const double occupied_limit = log_odds_of(config.occupied_threshold) + kTieLogOdds;
  return count_all(
      0.0, log_odds_of(config.prob_hit), log_odds_of(config.prob_miss), log_odds_of(config.prob_clamp_min),
      log_odds_of(config.prob_clamp_max), [=](double l) { return l < free_limit; },
      [=](double l) { return l > occupied_limit; });
}

Transitions transitions_of(const LogOddsScale& scale, const StateLevels& levels) {
  using containers::VoxelState;
  return count_all<int>(
      scale.prior, scale.hit, -scale.miss, 0, scale.max, [&](int l) { return levels.of(l) == VoxelState::kFree; },
      [&](int l) { return levels.of(l) == VoxelState::kOccupied; });
}

int mismatch(const Transitions& a, const Transitions& b) {
  return std::abs(a.hits_unknown_to_occupied - b.hits_unknown_to_occupied) +
         std::abs(a.misses_unknown_to_free - b.misses_unknown_to_free) +
         std::abs(a.misses_full_to_not_occupied - b.misses_full_to_not_occupied) +
         std::abs(a.misses_full_to_free - b.misses_full_to_free) +
         std::abs(a.hits_empty_to_not_free - b.hits_empty_to_not_free) +
         std::abs(a.hits_empty_to_occupied - b.hits_empty_to_occupied);
}

LogOddsScale LogOddsScale::from(const LocalMapConfig& config) {
  const double range = log_odds_of(config.prob_clamp_max) - log_odds_of(config.prob_clamp_min);
  const int finest = std::max(1, static_cast<int>(kMaxLevel * log_odds_of(config.prob_hit) / range));
  const double ratio = log_odds_of(config.prob_hit) / -log_odds_of(config.prob_miss);
  const Transitions ideal = ideal_transitions(config);
  LogOddsScale best = scale_with_hit(config, finest);
  double best_cost = 1e300;
  for (int hit = finest; hit >= 1; --hit) {
    const LogOddsScale scale = scale_with_hit(config, hit);
    const StateLevels levels(scale, config.free_threshold, config.occupied_threshold);
    // Scales with faithful counts are preferred, and among them the one with the truest ratio of a hit to a miss.
    const double cost = 100.0 * mismatch(ideal, transitions_of(scale, levels)) +
                        std::abs(static_cast<double>(scale.hit) / scale.miss / ratio - 1.0);
    if (cost < best_cost) {
      best_cost = cost;
      best = scale;
    }
  }
  return best;
}

}  // namespace voxnav::occupancy
