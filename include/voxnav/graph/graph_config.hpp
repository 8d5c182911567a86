// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::graph {

struct SubmapGraphConfig {
  // Registration of overlapping submaps
  bool is_registration_enabled = true;
  int sample_points = 1200;
  double sample_cell_m = 3.2;
  int points_per_pair = 200;
  int coarse_points = 400;
  int min_points_per_pair = 40;
  double min_overlap_ratio = 0.2;
  double overlap_refresh_m = 0.4;
  double registration_sigma_m = 0.2;
  double registration_effective_points = 50.0;
  double noise_floor = 0.03;
  double coarse_kernel_voxels = 4.0;
  double fine_kernel_voxels = 1.0;
  // Search for alignments that descent does not reach
  double search_range_m = 3.2;
  double search_range_rad = 0.2;
  int search_points = 100;
  double search_outlier_ratio = 0.1;
  double search_min_advantage = 0.9;
  int max_searches = 10;
  // Places seen before, farther off than the search reaches
  bool is_place_recognition_enabled = true;
  double place_min_support = 0.35;
  int place_candidates = 5;
  // Pairs
  double pair_block_m = 6.4;
  int max_pairs_per_submap = 40;
  int max_new_pairs = 200;
  int max_pairs = 10000;
  int max_submaps = 5000;
  // Loop closures and robustness
  bool is_loop_rejection_enabled = true;
  double loop_gate_chi2 = 25.0;
  double robust_width = 3.0;
  // Work per solve
  int max_iterations = 8;
  int max_solver_iterations = 100;
  int max_pair_evaluations = 1500;
  double convergence_m = 0.005;

  template <class V>
  static void fields(V&& v);
  std::vector<std::string> problems() const;
};

template <class V>
void SubmapGraphConfig::fields(V&& v) {
  using C = SubmapGraphConfig;
  using base::in;
  v("is_registration_enabled", &C::is_registration_enabled, base::any(), "", "register overlapping submaps");
  v("sample_points", &C::sample_points, in(50, 20000), "", "surface points kept per submap for registration");
  v("sample_cell_m", &C::sample_cell_m, in(0.1, 50), "m", "points are spread evenly over cells of this edge");
  v("points_per_pair", &C::points_per_pair, in(20, 5000), "", "points per direction used to register a pair");
  v("coarse_points", &C::coarse_points, in(20, 5000), "", "points per direction while a pair is still metres off");
  v("min_points_per_pair", &C::min_points_per_pair, in(5, 5000), "", "pairs with fewer points are not registered");
  v("min_overlap_ratio", &C::min_overlap_ratio, in(0.01, 1), "", "share of a submap's points inside the other");
  v("overlap_refresh_m", &C::overlap_refresh_m, in(0.1, 10), "m",
    "the points of a pair are chosen again after a move of this length");
  v("registration_sigma_m", &C::registration_sigma_m, in(0.001, 10), "m", "standard deviation of one surface distance");
  v("registration_effective_points", &C::registration_effective_points, in(1, 1e5), "",
    "independent distances a full pair is worth; its points are correlated");
  v("noise_floor", &C::noise_floor, in(0, 0.5), "", "mean squared slope below which a direction is left free");
  v("coarse_kernel_voxels", &C::coarse_kernel_voxels, in(0.5, 50), "voxels", "robust kernel where descent starts");
  v("fine_kernel_voxels", &C::fine_kernel_voxels, in(0.25, 50), "voxels", "robust kernel where descent ends");
  v("search_range_m", &C::search_range_m, in(0, 20), "m",
    "half width of the search window in x and y; 0 switches the search off");
  v("search_range_rad", &C::search_range_rad, in(0, 3.2), "rad", "half width of the search window in yaw");
  v("search_points", &C::search_points, in(20, 2000), "", "points per direction used by the search");
  v("search_outlier_ratio", &C::search_outlier_ratio, in(0, 1), "",
    "search when descent leaves a larger share of outliers");
  v("search_min_advantage", &C::search_min_advantage, in(0, 1), "",
    "the best cost must be below this share of the cost of every other alignment");
  v("max_searches", &C::max_searches, in(0, 1000), "", "searches per solve");
  v("is_place_recognition_enabled", &C::is_place_recognition_enabled, base::any(), "",
    "look for places seen before, however far the estimate has drifted");
  v("place_min_support", &C::place_min_support, in(0.05, 1), "",
    "share of a submap that must fit where a place was recognised");
  v("place_candidates", &C::place_candidates, in(1, 100), "", "similar places that are tried for each submap");
  v("pair_block_m", &C::pair_block_m, in(0.5, 50), "m", "edge of the spatial index that finds overlapping submaps");
  v("max_pairs_per_submap", &C::max_pairs_per_submap, in(1, 1000), "", "pairs formed by a submap with older ones");
  v("max_new_pairs", &C::max_new_pairs, in(1, 100000), "", "pairs formed per solve; the rest waits for the next");
  v("max_pairs", &C::max_pairs, in(1, 1000000), "", "pairs in the graph");
  v("max_submaps", &C::max_submaps, in(1, 100000), "", "submaps in the graph; more are refused");
  v("is_loop_rejection_enabled", &C::is_loop_rejection_enabled, base::any(), "", "test loop closures before use");
  v("loop_gate_chi2", &C::loop_gate_chi2, in(1, 1000), "", "largest squared Mahalanobis distance of a loop (4 dof)");
  v("robust_width", &C::robust_width, in(0.1, 100), "sigma", "residual at which GNSS and height begin to lose weight");
  v("max_iterations", &C::max_iterations, in(1, 1000), "", "linearisations of the registered pairs per solve");
  v("max_solver_iterations", &C::max_solver_iterations, in(1, 10000), "", "steps of the pose graph solver");
  v("max_pair_evaluations", &C::max_pair_evaluations, in(10, 10000000), "",
    "evaluations of pairs per solve after which no further trial step begins");
  v("convergence_m", &C::convergence_m, in(1e-6, 1), "m", "stop when no submap moves farther (yaw: at 20 m)");
}

}  // namespace voxnav::graph
