// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

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

/// How submaps are merged, and how many of them are kept.
struct SubmapCollectionConfig {
  double resolution_m = 0.4;
  double clearing_distance_m = 0.4;
  double thin_range_m = 6.0;
  double pose_tolerance_m = 0.02;
  int max_submaps = 5000;
  double max_memory_mb = 2000.0;
  double max_resident_mb = 100.0;
  std::string page_dir;

  template <class V>
  static void fields(V&& v) {
    v("resolution_m", &SubmapCollectionConfig::resolution_m, base::in(0.05, 5.0), "m", "voxel edge of the merged map");
    v("clearing_distance_m", &SubmapCollectionConfig::clearing_distance_m, base::in(0.0, 5.0), "m",
      "newer free space removes an older surface unless the newer submap has one of its own nearer than this");
    v("thin_range_m", &SubmapCollectionConfig::thin_range_m, base::in(0.0, 100.0), "m",
      "wires and poles are removed only by free space seen from this near, or from as near as they were seen");
    v("pose_tolerance_m", &SubmapCollectionConfig::pose_tolerance_m, base::in(0.0, 1.0), "m",
      "a submap is merged again if a corner of its box moved farther than this");
    v("max_submaps", &SubmapCollectionConfig::max_submaps, base::in(1, 1000000), "",
      "submaps beyond which the oldest one is dropped");
    v("max_memory_mb", &SubmapCollectionConfig::max_memory_mb, base::in(1.0, 1e6), "MB",
      "memory of all submaps beyond which the oldest one is dropped");
    v("max_resident_mb", &SubmapCollectionConfig::max_resident_mb, base::in(1.0, 1e6), "MB",
      "memory beyond which the least recently used submaps are moved to page_dir");
    v("page_dir", &SubmapCollectionConfig::page_dir, base::any(), "",
      "folder of the submaps that are not in memory; empty = all stay in memory");
  }
};

}  // namespace voxnav::submap
