// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {

/// How the space around a vehicle is divided into sectors.
struct ObstacleSectorsConfig {
  int num_horizontal = 8;
  double vertical_fov_rad = 1.0471975511965976;
  double max_range_m = 10.0;
  double body_radius_m = 0.4;

  template <class V>
  static void fields(V&& v) {
    using C = ObstacleSectorsConfig;
    v("num_horizontal", &C::num_horizontal, base::in(1, 360), "", "sectors around the vehicle, the first one ahead");
    v("vertical_fov_rad", &C::vertical_fov_rad, base::in(0.01, 3.14), "rad",
      "angle that a horizontal sector spans vertically; what is above or below belongs to the sectors top and bottom");
    v("max_range_m", &C::max_range_m, base::in(1.0, 100.0), "m", "farther obstacles are not reported");
    v("body_radius_m", &C::body_radius_m, base::in(0.0, 5.0), "m",
      "voxels whose middle is nearer than this are taken for the vehicle itself");
  }
  std::vector<std::string> problems() const;
};

/// What is known of one sector.
struct ObstacleSector {
  bool is_known = false;      ///< an obstacle is seen in it, or most of its space within range is known to be free
  bool has_obstacle = false;  ///< one is occupied
  double distance_m = 0.0;    ///< to the nearest point of an occupied voxel, if there is one
};

/// Returns the nearest obstacle in each sector around a vehicle: the horizontal ones counter-clockwise, the first one
/// centred ahead, then the one below and the one above. A voxel belongs to the sector in which its middle is seen. The
/// distance is that to the nearest point of its cube, since its surface may be anywhere in it. A sector of which little
/// is known is not known: the few free voxels beside a vehicle must not pass for a free way.
/// O(blocks within range). Source of the sectors: mrs_msgs/ObstacleSectors.
/// @throws std::invalid_argument if the position or the heading is not finite
std::vector<ObstacleSector> obstacle_sectors(const ObstacleSectorsConfig& config, const OccupancyView& view,
                                             const geometry::Vec3& position, double heading_rad);

}  // namespace voxnav::planning
