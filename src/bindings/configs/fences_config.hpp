// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "voxnav/base/config.hpp"

namespace voxnav::bindings {

/// Parameters of the fences of the planning_manager node: the files that they are read from, and how many and how large
/// they may be.
struct FencesConfig {
  std::string world_config;
  std::string zones_file;
  int max_zones = 100;
  int max_corners = 200;
  double max_zone_size_m = 1000.0;
  double max_area_size_m = 20000.0;

  template <class V>
  static void fields(V&& v) {
    using C = FencesConfig;
    using base::in;
    v("world_config", &C::world_config, base::any(), "",
      "world configuration of MRS whose safety area holds; empty = no safety area");
    v("zones_file", &C::zones_file, base::any(), "", "file of no-fly zones; empty = none at the start");
    v("max_zones", &C::max_zones, in(0, 1000), "", "no-fly zones at most");
    v("max_corners", &C::max_corners, in(3, 2000), "", "corners of one outline at most");
    v("max_zone_size_m", &C::max_zone_size_m, in(1, 5000), "m", "a zone may be this wide and high at most");
    v("max_area_size_m", &C::max_area_size_m, in(1, 50000), "m", "the safety area may be this wide and high at most");
  }
};

}  // namespace voxnav::bindings
