// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "ground_plan.hpp"
#include "voxnav_simulation/terrain.hpp"
#include "voxnav_simulation/world.hpp"

namespace voxnav_simulation {

/// A world under construction. Each of the functions below adds one kind of object and returns how many found room.
struct Site {
  const WorldConfig& config;
  std::uint64_t seed;
  const Terrain& terrain;
  GroundPlan ground_plan;
  WorldMesh* mesh;
  std::vector<Stem>* stems;

  double hectares() const { return config.size_m[0] * config.size_m[1] * 1e-4; }
  /// Returns the point on the ground at x, y, which must be inside the terrain.
  Vec3 on_ground(const Eigen::Vector2d& p) const { return {p.x(), p.y(), terrain.height(p.x(), p.y()).value()}; }
};

int plant_trees(Site* site);
int plant_bushes(Site* site);
int place_poles(Site* site);
int place_rocks(Site* site);
int build_walls(Site* site);
int build_houses(Site* site);
/// Returns a fire truck in its own frame, with the origin on the ground below its middle and x forward.
WorldMesh make_fire_truck();
/// The radius of a disc that contains the footprint of the fire truck.
inline constexpr double kVehicleRadiusM = 4.6;

}  // namespace voxnav_simulation
