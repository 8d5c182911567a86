// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/base/config.hpp"

namespace voxnav::submap {

/// Parameters of a submap and its distances.
struct SubmapConfig {
  double band_voxels = 3.0;
  double max_distance_m = 10.0;
  int max_surface_points = 4000;
  bool certified = false;

  template <class V>
  static void fields(V&& v) {
    v("band_voxels", &SubmapConfig::band_voxels, base::in(2.6, 6.0), "voxels",
      "distances up to here are computed for each voxel and interpolated; farther ones are searched exactly");
    v("max_distance_m", &SubmapConfig::max_distance_m, base::in(1.0, 50.0), "m",
      "distances saturate here, and the gradient is zero beyond");
    v("max_surface_points", &SubmapConfig::max_surface_points, base::in(10, 100000), "",
      "surface points kept for registration, spread evenly over the surface");
    v("certified", &SubmapConfig::certified, base::any(), "",
      "distances never exceed the true distance to the nearest occupied voxel (slower queries)");
  }
};

}  // namespace voxnav::submap
