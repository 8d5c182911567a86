// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/world_config.hpp"

#include <algorithm>

#include "voxnav_simulation/flat_yaml.hpp"

namespace voxnav_simulation {
namespace {

constexpr double kMaxTriangles = 2.0e7;  // for which Embree needs about 3 GB of memory
constexpr double kTrianglesPerTreeWood = 200.0;
constexpr double kMaxMovers = 100.0;

bool is_inside(const WorldConfig& c, const std::array<double, 2>& p) {
  for (std::size_t i = 0; i < 2; ++i) {
    if (!(p[i] >= c.min_corner_m[i] && p[i] <= c.min_corner_m[i] + c.size_m[i])) return false;
  }
  return true;
}

double expected_triangles(const WorldConfig& c) {
  const double hectares = c.size_m[0] * c.size_m[1] / 1.0e4;
  const double trees = c.trees_per_ha * hectares * (kTrianglesPerTreeWood + c.leaves_per_tree);
  const double bushes = c.bushes_per_ha * hectares * c.leaves_per_bush;
  const double cells = (c.size_m[0] + 2 * c.terrain_margin_m) * (c.size_m[1] + 2 * c.terrain_margin_m) /
                       (c.terrain_cell_m * c.terrain_cell_m);
  return trees + bushes + 2.0 * cells;
}

/// Whether rows of `width` numbers are complete and finite, lie inside, and count their movers from 0 without gaps.
bool are_ways(const WorldConfig& c, const std::vector<double>& rows, std::size_t width) {
  if (rows.size() % width != 0) return false;
  double movers = 0;
  for (std::size_t i = 0; i < rows.size(); i += width) {
    if (rows[i] != movers && rows[i] != movers - 1) return false;
    movers = std::max(movers, rows[i] + 1);
    if (!is_inside(c, {rows[i + 1], rows[i + 2]}) || (width > 3 && !(rows[i + 3] >= 0 && rows[i + 3] < 1000)))
      return false;
  }
  return movers <= kMaxMovers;
}

}  // namespace

std::vector<std::string> WorldConfig::problems() const {
  std::vector<std::string> out;
  const auto require = [&](bool holds, const char* text) {
    if (!holds) out.emplace_back(text);
  };
  require(is_inside(*this, start_m), "start_m must lie inside the populated area");
  require(is_inside(*this, goal_m), "goal_m must lie inside the populated area");
  require(!has_vehicle || is_inside(*this, vehicle_position_m),
          "vehicle_position_m must lie inside the populated area");
  require(trunk_radius_min_m <= trunk_radius_max_m, "trunk_radius_min_m must not exceed trunk_radius_max_m");
  require(pole_radius_min_m <= pole_radius_max_m, "pole_radius_min_m must not exceed pole_radius_max_m");
  require(crown_base_min_m <= crown_base_max_m, "crown_base_min_m must not exceed crown_base_max_m");
  require(tree_spacing_m > 2.0 * trunk_radius_max_m, "tree_spacing_m must exceed twice trunk_radius_max_m");
  require(are_ways(*this, walker_waypoints, 3),
          "walker_waypoints needs three numbers each, persons counted from 0 in order, inside the populated area");
  require(are_ways(*this, flyer_waypoints, 4),
          "flyer_waypoints needs four numbers each, UAVs counted from 0 in order, inside the populated area");
  require(expected_triangles(*this) < kMaxTriangles, "the world would have more than 20 million triangles");
  return out;
}

WorldConfig load_world_config(const std::string& path) {
  WorldConfig config;
  const auto problems = voxnav::base::assign(&config, read_flat_yaml(path), path + ": ");
  if (!problems.empty()) throw voxnav::base::ConfigError(problems);
  return config;
}

}  // namespace voxnav_simulation
