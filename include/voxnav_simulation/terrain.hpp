// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "voxnav_simulation/mesh.hpp"
#include "voxnav_simulation/world_config.hpp"

namespace voxnav_simulation {

/// Rolling ground: heights on a regular grid with two triangles per cell. The height at the start is 0.
class Terrain {
 public:
  Terrain(const WorldConfig& config, std::uint64_t seed);

  /// Returns the height of the triangle mesh at (x, y), or nothing outside of the grid.
  std::optional<double> height(double x, double y) const;
  void append_to(WorldMesh* mesh) const;

 private:
  double vertex_height(int ix, int iy) const { return heights_[static_cast<std::size_t>(iy) * num_x_ + ix]; }

  double min_x_, min_y_, cell_m_;
  int num_x_, num_y_;  ///< vertices, not cells
  std::vector<double> heights_;
};

}  // namespace voxnav_simulation
