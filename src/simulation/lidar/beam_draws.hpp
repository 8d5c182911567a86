// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

/// Keys under which one beam draws its numbers, so that these are independent of each other.
enum Draw : std::uint64_t {
  kRangeDraw = 1,
  kSignalDraw = 2,
  kDropoutDraw = 3,
  kGhostDraw = 4,
  kFootprintDraw = 5,
  kRainDraw = 6,
  kSpeckleDraw = 7,
};
constexpr std::uint64_t kDraws = 16;  ///< room for the numbers of one beam

inline std::uint64_t draw(std::uint64_t key, Draw which) { return mix_bits(key + which); }

/// A number in [0, 1), made from the upper or the lower half of a draw.
inline float upper_uniform(std::uint64_t bits) { return static_cast<float>(bits >> 40) * 0x1.0p-24F; }
inline float lower_uniform(std::uint64_t bits) { return static_cast<float>(bits & 0xFFFFFFU) * 0x1.0p-24F; }

/// A nearly standard normal number, never beyond 3.46: the sum of four uniform numbers costs a fraction of a logarithm.
inline float normal(std::uint64_t bits) {
  const auto sum =
      static_cast<float>((bits & 0xFFFFU) + ((bits >> 16) & 0xFFFFU) + ((bits >> 32) & 0xFFFFU) + (bits >> 48));
  constexpr float kScale = 1.7320508F / 65536.0F;
  return (sum - 131070.0F) * kScale;
}

}  // namespace voxnav_simulation
