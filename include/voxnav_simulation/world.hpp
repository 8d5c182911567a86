// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxnav_simulation/mesh.hpp"
#include "voxnav_simulation/movers.hpp"
#include "voxnav_simulation/terrain.hpp"
#include "voxnav_simulation/world_config.hpp"

namespace voxnav_simulation {

/// The exact shape of a trunk or pole, by which tests and benchmarks measure how well a map represents it. Its axis
/// goes from the ground to the top.
struct Stem {
  Rod rod;
  SurfaceClass surface_class;  ///< kTrunk or kPole
};

/// The number of objects of each kind, which is lower than requested if there was no room for more.
struct WorldCounts {
  int num_trees = 0;
  int num_bushes = 0;
  int num_poles = 0;
  int num_rocks = 0;
  int num_walls = 0;
  int num_houses = 0;
};

/// A generated world, in frame W with z up and ground height 0 at the start. The same configuration and seed give the
/// same bytes. Leaves are triangles with gaps between them rather than a statistical filter on the beams: two beams
/// along the same line give the same result, the true clearance to a leaf is defined, and ray packets stay fast.
class World {
 public:
  /// @throws voxnav::base::ConfigError
  World(const WorldConfig& config, std::uint64_t seed);

  const WorldConfig& config() const { return config_; }
  std::uint64_t seed() const { return seed_; }
  /// The triangles of all objects that never move.
  const WorldMesh& mesh() const { return mesh_; }
  /// The vehicle in its own frame, with the origin on the ground below its middle and x forward; empty if there is
  /// none.
  const WorldMesh& vehicle_mesh() const { return vehicle_mesh_; }
  const std::vector<Stem>& stems() const { return stems_; }
  const WorldCounts& counts() const { return counts_; }
  /// Persons and other UAVs, which are not part of the mesh.
  const std::vector<Mover>& movers() const { return movers_; }
  std::optional<double> ground_height(double x, double y) const { return terrain_.height(x, y); }
  /// Returns the pose of the vehicle when it stands level on the ground, or nothing outside of the terrain.
  std::optional<Pose> vehicle_pose(double x, double y, double heading_rad) const;

 private:
  WorldConfig config_;
  std::uint64_t seed_;
  Terrain terrain_;
  WorldMesh mesh_;
  WorldMesh vehicle_mesh_;
  std::vector<Stem> stems_;
  WorldCounts counts_;
  std::vector<Mover> movers_;
};

/// Writes the static mesh, and the vehicle if a pose is given, as a PLY file. Its header holds seed and configuration.
void save_ply(const World& world, const std::optional<Pose>& T_W_vehicle, const std::string& path);

}  // namespace voxnav_simulation
