// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

namespace voxnav_simulation {

/// Mixes 64 bits, so that similar inputs give unrelated outputs. Source: the generator SplitMix64 of Steele, Lea and
/// Flood, Fast splittable pseudorandom number generators, OOPSLA 2014, with the constants of Stafford's variant 13.
inline std::uint64_t mix_bits(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

/// Seeded numbers that are the same with every compiler and standard library (std::*_distribution is not).
class Rng {
 public:
  /// Streams of one seed are independent: changing how many rocks there are leaves the trees where they were.
  explicit Rng(std::uint64_t seed, std::uint64_t stream = 0) : state_(mix_bits(seed) ^ mix_bits(~stream)) {}

  std::uint64_t next() { return mix_bits(state_++); }
  /// Returns a number that is uniformly distributed in [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Returns a number with the standard normal distribution.
  /// Source: Box & Muller, "A note on the generation of random normal deviates", 1958.
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * M_PI * uniform());
  }
  /// Returns a number with the exponential distribution of this mean: the time to the next of events that come at
  /// random.
  double exponential(double mean) { return -mean * std::log(1.0 - uniform()); }

 private:
  std::uint64_t state_;
};

}  // namespace voxnav_simulation
