// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::pipeline {

/// Section `time` of every node: whether time is real, or that of a simulation that waits for the nodes.
struct TimeConfig {
  bool waits_for_simulation = false;
  std::vector<std::string> consumers{};

  template <class V>
  static void fields(V&& v) {
    using C = TimeConfig;
    v("waits_for_simulation", &C::waits_for_simulation, base::any(), "",
      "a simulation lets no time pass while this node works, so that results do not depend on the machine; "
      "false: time runs by itself");
    v("consumers", &C::consumers, base::any(), "",
      "nodes that receive the output of this node; such a simulation waits for them too");
  }
};

}  // namespace voxnav::pipeline
