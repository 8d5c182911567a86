// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::bindings {

/// Section `work` of the planning_manager node: the simulated time that its work takes in a simulation that waits for
/// it, where otherwise all work takes none. Each duration lies evenly distributed between a least and a greatest time,
/// and is rounded to the instants at which such a simulation stands still.
struct WorkTimeConfig {
  std::array<double, 2> search_s{0.0, 0.0};
  std::array<double, 2> generator_s{0.0, 0.0};
  std::array<double, 2> command_s{0.0, 0.0};
  int seed = 1;

  template <class V>
  static void fields(V&& v) {
    using C = WorkTimeConfig;
    using base::in;
    v("search_s", &C::search_s, in(0, 10), "s",
      "least and greatest simulated time of a search; its map is that at its begin");
    v("generator_s", &C::generator_s, in(0, 10), "s", "least and greatest simulated time of the trajectory generator");
    v("command_s", &C::command_s, in(0, 10), "s", "least and greatest simulated time until a command is obeyed");
    v("seed", &C::seed, in(0, 2147483647), "", "seed of these durations");
  }
  std::vector<std::string> problems() const {
    std::vector<std::string> out;
    for (const auto& bounds : {search_s, generator_s, command_s}) {
      if (bounds[0] > bounds[1]) out.emplace_back("the least time of a piece of work must not exceed its greatest");
    }
    return out;
  }
};

}  // namespace voxnav::bindings
