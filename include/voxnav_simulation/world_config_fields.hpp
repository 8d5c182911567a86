// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav_simulation/world_config.hpp"

namespace voxnav_simulation {

template <class V>
void WorldConfig::area_fields(V& v) {
  using C = WorldConfig;
  using voxnav::base::in;
  v("min_corner_m", &C::min_corner_m, in(-5000, 5000), "m", "south-west corner of the populated area");
  v("size_m", &C::size_m, in(10, 2000), "m", "size of the populated area along x and y");
  v("start_m", &C::start_m, in(-5000, 5000), "m", "take-off point, kept clear; the ground has height 0 here");
  v("goal_m", &C::goal_m, in(-5000, 5000), "m", "goal, kept clear");
  v("clear_radius_m", &C::clear_radius_m, in(0, 50), "m", "nothing stands closer to start and goal");
  v("terrain_margin_m", &C::terrain_margin_m, in(0, 200), "m", "bare ground around the populated area");
  v("terrain_cell_m", &C::terrain_cell_m, in(0.2, 10), "m", "edge of one terrain cell");
  v("terrain_amplitude_m", &C::terrain_amplitude_m, in(0, 20), "m", "standard deviation of the ground's height");
  v("terrain_wavelength_m", &C::terrain_wavelength_m, in(5, 500), "m", "longest undulation of the ground");
  v("terrain_roughness_m", &C::terrain_roughness_m, in(0, 0.5), "m", "standard deviation of each terrain vertex");
}

template <class V>
void WorldConfig::tree_fields(V& v) {
  using C = WorldConfig;
  using voxnav::base::in;
  v("trees_per_ha", &C::trees_per_ha, in(0, 1000), "1/ha", "trees per hectare of the populated area");
  v("tree_spacing_m", &C::tree_spacing_m, in(0.5, 20), "m", "least distance between two trunk axes");
  v("trunk_radius_min_m", &C::trunk_radius_min_m, in(0.02, 1), "m", "thinnest trunk at the ground");
  v("trunk_radius_max_m", &C::trunk_radius_max_m, in(0.02, 1), "m", "thickest trunk at the ground");
  v("trunk_lean_max_rad", &C::trunk_lean_max_rad, in(0, 0.5), "rad", "largest lean of a trunk");
  v("conifer_ratio", &C::conifer_ratio, in(0, 1), "",
    "share of trees with a cone as crown, the others have an ellipsoid");
  v("crown_base_min_m", &C::crown_base_min_m, in(0.5, 20), "m", "lowest crown above the ground");
  v("crown_base_max_m", &C::crown_base_max_m, in(0.5, 20), "m", "highest lower edge of a crown");
  v("crown_radius_max_m", &C::crown_radius_max_m, in(0.3, 10), "m", "widest crown");
  v("branches_per_tree", &C::branches_per_tree, in(0, 100), "", "branches inside the crown");
  v("low_branch_ratio", &C::low_branch_ratio, in(0, 1), "", "share of trees with dead branches below the crown");
  v("leaves_per_tree", &C::leaves_per_tree, in(0, 50000), "", "leaf triangles per crown; their gaps let beams through");
  v("leaf_size_m", &C::leaf_size_m, in(0.02, 1), "m", "edge of a leaf triangle");
  v("twigs_per_tree", &C::twigs_per_tree, in(0, 5000), "", "leafless twigs in and around the crown");
  v("twig_radius_m", &C::twig_radius_m, in(0.0005, 0.02), "m", "radius of a twig, which fills only part of a beam");
}

template <class V>
void WorldConfig::object_fields(V& v) {
  using C = WorldConfig;
  using voxnav::base::any;
  using voxnav::base::in;
  v("bushes_per_ha", &C::bushes_per_ha, in(0, 1000), "1/ha", "bushes per hectare");
  v("bush_radius_max_m", &C::bush_radius_max_m, in(0.3, 3), "m", "widest bush");
  v("leaves_per_bush", &C::leaves_per_bush, in(0, 20000), "", "leaf triangles per bush");
  v("num_poles", &C::num_poles, in(0, 1000), "", "thin vertical poles");
  v("pole_radius_min_m", &C::pole_radius_min_m, in(0.005, 0.5), "m", "thinnest pole");
  v("pole_radius_max_m", &C::pole_radius_max_m, in(0.005, 0.5), "m", "thickest pole");
  v("pole_height_m", &C::pole_height_m, in(0.5, 50), "m", "height of poles");
  v("rocks_per_ha", &C::rocks_per_ha, in(0, 1000), "1/ha", "rocks per hectare");
  v("rock_radius_max_m", &C::rock_radius_max_m, in(0.2, 5), "m", "largest rock");
  v("num_walls", &C::num_walls, in(0, 200), "", "free-standing walls");
  v("wall_length_m", &C::wall_length_m, in(1, 100), "m", "length of walls");
  v("wall_height_m", &C::wall_height_m, in(0.3, 20), "m", "height of walls");
  v("num_houses", &C::num_houses, in(0, 200), "", "houses with gable roofs");
  v("has_vehicle", &C::has_vehicle, any(), "", "a fire truck stands in the world and can be moved");
  v("vehicle_position_m", &C::vehicle_position_m, in(-5000, 5000), "m", "where the vehicle stands at first");
  v("vehicle_heading_rad", &C::vehicle_heading_rad, in(-6.3, 6.3), "rad", "its heading at first");
}

template <class V>
void WorldConfig::mover_fields(V& v) {
  using C = WorldConfig;
  using voxnav::base::any;
  using voxnav::base::in;
  v("num_walkers", &C::num_walkers, in(0, 100), "", "persons that walk to and fro across the way from start to goal");
  v("walker_speed_mps", &C::walker_speed_mps, in(0, 10), "m/s", "speed of all persons");
  v("walker_waypoints", &C::walker_waypoints, any(), "",
    "way points of further persons, three numbers each: which person (0, 1, ...), x and y; walked round and round");
  v("num_flyers", &C::num_flyers, in(0, 100), "", "other UAVs that fly to and fro across the way from start to goal");
  v("flyer_speed_mps", &C::flyer_speed_mps, in(0, 20), "m/s", "speed of all other UAVs");
  v("flyer_waypoints", &C::flyer_waypoints, any(), "",
    "way points of further UAVs, four numbers each: which UAV (0, 1, ...), x, y and height above the ground");
}

}  // namespace voxnav_simulation
