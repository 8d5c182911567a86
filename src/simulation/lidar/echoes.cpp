// SPDX-License-Identifier: BSD-3-Clause
#include "echoes.hpp"

#include <algorithm>
#include <array>

namespace voxnav_simulation {
namespace {

Echo echo_of(const RayReturn* begin, const RayReturn* end, std::size_t num_rays) {
  std::array<float, kNumSurfaceClasses> power_of_class{};
  float power = 0.0F, weighted_range = 0.0F;
  for (const RayReturn* r = begin; r != end; ++r) {
    power += r->power;
    weighted_range += r->power * r->range_m;
    power_of_class[static_cast<std::size_t>(r->surface_class)] += r->power;
  }
  const auto strongest = std::max_element(power_of_class.begin(), power_of_class.end()) - power_of_class.begin();
  // A single surface keeps its range to the last bit.
  const float range = end - begin == 1 || power <= 0.0F ? begin->range_m : weighted_range / power;
  return {range, power / static_cast<float>(num_rays), static_cast<SurfaceClass>(strongest)};
}

float signal_of(const Echo& echo) { return echo.power / (echo.range_m * echo.range_m); }

}  // namespace

std::optional<Echo> strongest_echo(RayReturn* returns, std::size_t num_returns, std::size_t num_rays,
                                   float separation_m) {
  std::sort(returns, returns + num_returns, [](const auto& a, const auto& b) { return a.range_m < b.range_m; });
  std::optional<Echo> best;
  for (std::size_t first = 0, next = 0; first < num_returns; first = next) {
    for (next = first + 1; next < num_returns; ++next) {
      if (returns[next].range_m - returns[next - 1].range_m > separation_m) break;
    }
    const Echo echo = echo_of(returns + first, returns + next, num_rays);
    if (!best || signal_of(echo) > signal_of(*best)) best = echo;
  }
  return best;
}

}  // namespace voxnav_simulation
