// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/world.hpp"

#include "site.hpp"

namespace voxnav_simulation {
namespace {

Eigen::Vector2d as_vector(const std::array<double, 2>& p) { return {p[0], p[1]}; }

void keep_clear(const WorldConfig& config, GroundPlan* ground_plan) {
  ground_plan->add(as_vector(config.start_m), config.clear_radius_m);
  ground_plan->add(as_vector(config.goal_m), config.clear_radius_m);
  if (config.has_vehicle) ground_plan->add(as_vector(config.vehicle_position_m), kVehicleRadiusM);
}

}  // namespace

World::World(const WorldConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)), seed_(seed), terrain_(config_, seed) {
  terrain_.append_to(&mesh_);
  Site site{config_, seed, terrain_, GroundPlan(config_), &mesh_, &stems_};
  keep_clear(config_, &site.ground_plan);
  // Large objects are placed first, while there is room for them.
  counts_.num_houses = build_houses(&site);
  counts_.num_walls = build_walls(&site);
  counts_.num_trees = plant_trees(&site);
  counts_.num_poles = place_poles(&site);
  counts_.num_rocks = place_rocks(&site);
  counts_.num_bushes = plant_bushes(&site);
  if (config_.has_vehicle) vehicle_mesh_ = make_fire_truck();
  movers_ = make_movers(config_, seed, terrain_);
}

std::optional<Pose> World::vehicle_pose(double x, double y, double heading_rad) const {
  const std::optional<double> z = ground_height(x, y);
  if (!z || !std::isfinite(heading_rad)) return std::nullopt;
  return voxnav::geometry::from_position_yaw({x, y, *z}, heading_rad);
}

void save_ply(const World& world, const std::optional<Pose>& T_W_vehicle, const std::string& path) {
  std::vector<std::string> comments{"voxnav world, z up, metres", "seed " + std::to_string(world.seed())};
  for (const auto& field : voxnav::base::describe(world.config())) {
    comments.push_back(field.name + " " + voxnav::base::to_string(field.value));
  }
  WorldMesh mesh = world.mesh();
  if (T_W_vehicle) append_mesh(&mesh, world.vehicle_mesh(), *T_W_vehicle);
  save_ply(mesh, comments, path);
}

}  // namespace voxnav_simulation
