// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxnav_simulation/mesh.hpp"
#include "voxnav_simulation/terrain.hpp"
#include "voxnav_simulation/world_config.hpp"

namespace voxnav_simulation {

/// A trunk or pole as it was meant, for measuring how well a map keeps it: axis from the ground to the top.
struct Stem {
  Rod rod;
  SurfaceClass surface_class;  ///< kTrunk or kPole
};

/// The number of objects of each kind; lower than requested if no more found room.
struct WorldCounts {
  int num_trees = 0;
  int num_bushes = 0;
  int num_poles = 0;
  int num_rocks = 0;
  int num_walls = 0;
  int num_houses = 0;
};

/// A generated world: the same configuration and seed give the same bytes. Frame W, z up, ground height 0 at the start.
/// Leaves are real triangles with gaps between them, not a statistical filter on the beams: a second beam along the
/// same line gives the same answer, the true clearance to a leaf is defined, and ray packets stay fast.
class World {
 public:
  /// @throws voxnav::base::ConfigError
  World(const WorldConfig& config, std::uint64_t seed);

  const WorldConfig& config() const { return config_; }
  std::uint64_t seed() const { return seed_; }
  /// The triangles of everything that never moves.
  const WorldMesh& mesh() const { return mesh_; }
  /// The vehicle around its own origin (on the ground, below its middle, x forward); empty when there is none.
  const WorldMesh& vehicle_mesh() const { return vehicle_mesh_; }
  const std::vector<Stem>& stems() const { return stems_; }
  const WorldCounts& counts() const { return counts_; }
  std::optional<double> ground_height(double x, double y) const { return terrain_.height(x, y); }
  /// Pose of the vehicle when it stands level on the ground, or nothing outside of the terrain.
  std::optional<Pose> vehicle_pose(double x, double y, double heading_rad) const;

 private:
  WorldConfig config_;
  std::uint64_t seed_;
  Terrain terrain_;
  WorldMesh mesh_;
  WorldMesh vehicle_mesh_;
  std::vector<Stem> stems_;
  WorldCounts counts_;
};

/// Writes the static mesh with the vehicle where `T_W_vehicle` puts it, the seed in the header.
void save_ply(const World& world, const std::optional<Pose>& T_W_vehicle, const std::string& path);

}  // namespace voxnav_simulation
