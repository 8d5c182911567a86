// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::cloud {

/// Which returns of a scan are kept. All positions are in the sensor frame L.
struct CloudFilterConfig {
  double min_range_m = 0.3;
  double max_range_m = 120.0;
  double body_radius_m = 0.7;
  std::array<double, 3> body_center_m{0.0, 0.0, 0.0};
  bool use_body_box = false;
  std::array<double, 3> body_box_min_m{-0.5, -0.5, -0.5};
  std::array<double, 3> body_box_max_m{0.5, 0.5, 0.2};
  double ghost_intensity = 0.0;
  double ghost_range_m = 20.0;
  int row_decimation = 1;
  int column_decimation = 1;
  int unorganised_decimation = 1;
  bool cycle_decimation = false;
  bool remove_outliers = true;
  double outlier_max_range_m = 8.0;
  int outlier_min_neighbours = 2;
  double outlier_distance_m = 0.04;
  double outlier_range_ratio = 0.05;

  template <class V>
  static void fields(V&& v) {
    using C = CloudFilterConfig;
    v("min_range_m", &C::min_range_m, base::in(0, 100), "m", "nearer returns are dropped");
    v("max_range_m", &C::max_range_m, base::in(0.1, 1000), "m",
      "farther returns are dropped (and kept apart as far points)");
    v("body_radius_m", &C::body_radius_m, base::in(0, 20), "m", "own body: sphere, 0 switches it off");
    v("body_center_m", &C::body_center_m, base::in(-20, 20), "m", "own body: centre of the sphere, sensor frame");
    v("use_body_box", &C::use_body_box, base::any(), "", "own body: remove a box as well");
    v("body_box_min_m", &C::body_box_min_m, base::in(-20, 20), "m", "own body: lower corner of the box, sensor frame");
    v("body_box_max_m", &C::body_box_max_m, base::in(-20, 20), "m", "own body: upper corner of the box, sensor frame");
    v("ghost_intensity", &C::ghost_intensity, base::in(0, 1e6), "",
      "returns weaker than this and nearer than ghost_range_m are sunlight ghosts; the sensor's own unit, 0 switches "
      "it off");
    v("ghost_range_m", &C::ghost_range_m, base::in(0, 1000), "m", "beyond it weak returns are genuine");
    v("row_decimation", &C::row_decimation, base::in(1, 1024), "", "organised clouds: every n-th row");
    v("column_decimation", &C::column_decimation, base::in(1, 4096), "", "organised clouds: every n-th column");
    v("unorganised_decimation", &C::unorganised_decimation, base::in(1, 4096), "",
      "clouds of one row: every n-th point");
    v("cycle_decimation", &C::cycle_decimation, base::any(), "",
      "start one row, column or point later with each scan, so that every beam is used in turn");
    v("remove_outliers", &C::remove_outliers, base::any(), "",
      "organised clouds: drop near returns without neighbours at a similar range (rain, dust), unless they are most");
    v("outlier_max_range_m", &C::outlier_max_range_m, base::in(0, 1000), "m",
      "farther returns are kept: a LiDAR sees drops only nearby, and leaves far away have no neighbours either");
    v("outlier_min_neighbours", &C::outlier_min_neighbours, base::in(1, 14), "",
      "neighbours that a return needs among the 14 nearest pixels (3 rows, 5 columns)");
    v("outlier_distance_m", &C::outlier_distance_m, base::in(0, 10), "m", "distance to a neighbour, constant part");
    v("outlier_range_ratio", &C::outlier_range_ratio, base::in(0, 1), "",
      "distance to a neighbour, part per metre of range");
  }
  std::vector<std::string> problems() const;
};

}  // namespace voxnav::cloud
