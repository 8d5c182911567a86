// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>
#include <vector>

#include "voxnav/occupancy/local_map.hpp"

int main() {
  using namespace voxnav;
  occupancy::LocalMap map{occupancy::LocalMapConfig{}};
  // Three clouds of a wall, 8 m ahead of where the sensor begins, as it comes nearer. Points are in the sensor's frame.
  for (const double x_m : {0.0, 0.5, 1.0}) {
    std::vector<geometry::Vec3f> points_L;
    for (float y_m = -4.0f; y_m < 4.0f; y_m += 0.1f)
      for (float z_m = -1.0f; z_m < 1.0f; z_m += 0.1f) points_L.emplace_back(8.0 - x_m, y_m, z_m);
    map.insert(geometry::view_of(points_L), geometry::from_position_yaw({x_m, 0.0, 0.0}, 0.0));
  }
  const char* const words[] = {"unknown", "free", "occupied"};
  for (const double x_m : {4.0, 8.0, 12.0})
    std::cout << x_m << " m ahead: " << words[static_cast<int>(map.state({x_m, 0.0, 0.0}))] << "\n";
}
