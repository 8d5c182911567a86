// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav_simulation {

/// The contents of a generated world; worlds/*.yaml hold complete sets.
struct WorldConfig {
  std::array<double, 2> min_corner_m{-20.0, -30.0};
  std::array<double, 2> size_m{120.0, 60.0};
  std::array<double, 2> start_m{0.0, 0.0};
  std::array<double, 2> goal_m{75.0, 0.0};
  double clear_radius_m = 4.0;

  double terrain_margin_m = 20.0;
  double terrain_cell_m = 1.0;
  double terrain_amplitude_m = 0.6;
  double terrain_wavelength_m = 40.0;
  double terrain_roughness_m = 0.04;

  double trees_per_ha = 300.0;
  double tree_spacing_m = 2.5;
  double trunk_radius_min_m = 0.05;
  double trunk_radius_max_m = 0.40;
  double trunk_lean_max_rad = 0.12;
  double conifer_ratio = 0.5;
  double crown_base_min_m = 3.5;
  double crown_base_max_m = 5.0;
  double crown_radius_max_m = 2.6;
  int branches_per_tree = 8;
  double low_branch_ratio = 0.10;
  int leaves_per_tree = 300;
  double leaf_size_m = 0.30;
  int twigs_per_tree = 0;
  double twig_radius_m = 0.003;

  double bushes_per_ha = 60.0;
  double bush_radius_max_m = 0.9;
  int leaves_per_bush = 90;

  int num_poles = 6;
  double pole_radius_min_m = 0.02;
  double pole_radius_max_m = 0.05;
  double pole_height_m = 6.0;

  double rocks_per_ha = 40.0;
  double rock_radius_max_m = 0.8;
  int num_walls = 2;
  double wall_length_m = 8.0;
  double wall_height_m = 2.2;
  int num_houses = 1;

  bool has_vehicle = false;
  std::array<double, 2> vehicle_position_m{25.0, 0.0};
  double vehicle_heading_rad = 1.57;

  int num_walkers = 0;
  double walker_speed_mps = 1.4;
  std::vector<double> walker_waypoints{};
  int num_flyers = 0;
  double flyer_speed_mps = 2.0;
  std::vector<double> flyer_waypoints{};

  template <class V>
  static void fields(V&& v) {
    area_fields(v);
    tree_fields(v);
    object_fields(v);
    mover_fields(v);
  }
  std::vector<std::string> problems() const;

 private:
  template <class V>
  static void area_fields(V& v);
  template <class V>
  static void tree_fields(V& v);
  template <class V>
  static void object_fields(V& v);
  template <class V>
  static void mover_fields(V& v);
};

/// Reads a flat YAML file; parameters that it does not hold keep their defaults.
/// @throws voxnav::base::ConfigError listing every unknown key, wrong type and value out of range
WorldConfig load_world_config(const std::string& path);

}  // namespace voxnav_simulation

#include "voxnav_simulation/world_config_fields.hpp"  // IWYU pragma: export
