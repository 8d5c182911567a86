// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "site.hpp"
#include "streams.hpp"

namespace voxnav_simulation {
namespace {

constexpr double kWallThicknessM = 0.25;
constexpr double kBuildingGapM = 3.0;
constexpr double kFoundationM = 2.0;  // depth of walls below the floor, so that no gap shows on slopes

/// Appends a box whose bottom is kFoundationM below the origin of T_W_building and whose top is size_m.z() above it.
void append_block(WorldMesh* mesh, const Pose& T_W_building, const Vec3& size_m) {
  Pose T_building_box = Pose::Identity();
  T_building_box.translation().z() = 0.5 * (size_m.z() - kFoundationM);
  const Vec3 edges(size_m.x(), size_m.y(), size_m.z() + kFoundationM);
  append_box(mesh, T_W_building * T_building_box, edges, SurfaceClass::kBuilding);
}

/// Appends a gable roof on top of a block: two slopes and two gables, with the ridge along x.
void append_roof(WorldMesh* mesh, const Pose& T_W_building, const Vec3& size_m) {
  const double x = 0.5 * size_m.x() + 0.3, y = 0.5 * size_m.y() + 0.3, low = size_m.z(), high = low + 0.5 * y * 2.0;
  const std::array<Vec3, 6> corners{Vec3(-x, -y, low), Vec3(x, -y, low),  Vec3(x, y, low),
                                    Vec3(-x, y, low),  Vec3(-x, 0, high), Vec3(x, 0, high)};
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  for (const Vec3& corner : corners) mesh->add_vertex(T_W_building * corner);
  constexpr std::array<std::array<std::uint32_t, 3>, 8> kFaces{
      {{0, 1, 5}, {0, 5, 4}, {2, 3, 4}, {2, 4, 5}, {0, 4, 3}, {1, 2, 5}, {0, 3, 2}, {0, 2, 1}}};
  for (const auto& f : kFaces) mesh->add_triangle(first + f[0], first + f[1], first + f[2], SurfaceClass::kBuilding);
}

}  // namespace

int build_walls(Site* site) {
  const WorldConfig& config = site->config;
  Rng rng(site->seed, kWallStream);
  for (int i = 0; i < config.num_walls; ++i) {
    const double heading = rng.uniform(0.0, M_PI);
    const auto place = site->ground_plan.find(0.5 * config.wall_length_m, kBuildingGapM, &rng);
    if (!place) return i;
    const Pose T_W_wall = voxnav::geometry::from_position_yaw(site->on_ground(*place), heading);
    append_block(site->mesh, T_W_wall, {config.wall_length_m, kWallThicknessM, config.wall_height_m});
  }
  return config.num_walls;
}

int build_houses(Site* site) {
  Rng rng(site->seed, kHouseStream);
  for (int i = 0; i < site->config.num_houses; ++i) {
    const Vec3 size(rng.uniform(7.0, 11.0), rng.uniform(5.0, 8.0), rng.uniform(2.8, 4.5));
    const double heading = rng.uniform(0.0, M_PI);
    const auto place = site->ground_plan.find(0.5 * size.head<2>().norm() + 0.3, kBuildingGapM, &rng);
    if (!place) return i;
    const Pose T_W_house = voxnav::geometry::from_position_yaw(site->on_ground(*place), heading);
    append_block(site->mesh, T_W_house, size);
    append_roof(site->mesh, T_W_house, size);
  }
  return site->config.num_houses;
}

}  // namespace voxnav_simulation
