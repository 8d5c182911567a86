// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "ground_plan.hpp"
#include "voxnav_simulation/terrain.hpp"
#include "voxnav_simulation/world.hpp"

namespace voxnav_simulation {

/// A world under construction. Each function adds one kind of object and returns how many found room.
struct Site {
  const WorldConfig& config;
  std::uint64_t seed;
  const Terrain& terrain;
  GroundPlan ground_plan;
  WorldMesh* mesh;
  std::vector<Stem>* stems;

  double hectares() const { return config.size_m[0] * config.size_m[1] * 1e-4; }
  /// A point on the ground; places come from inside the terrain.
  Vec3 on_ground(const Eigen::Vector2d& p) const { return {p.x(), p.y(), terrain.height(p.x(), p.y()).value()}; }
};

int plant_trees(Site* site);
int plant_bushes(Site* site);
int place_poles(Site* site);
int place_rocks(Site* site);
int build_walls(Site* site);
int build_houses(Site* site);
/// A fire truck around its own origin: on the ground below its middle, x forward.
WorldMesh make_fire_truck();
/// Footprint of the fire truck, as a disc.
inline constexpr double kVehicleRadiusM = 4.6;

}  // namespace voxnav_simulation
