// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "voxnav_simulation/mesh.hpp"
#include "voxnav_simulation/random.hpp"
#include "voxnav_simulation/world_config.hpp"

namespace voxnav_simulation {

/// Finds room on the ground for round footprints that keep away from each other.
class GroundPlan {
 public:
  explicit GroundPlan(const WorldConfig& config);

  /// Reserves a random place in the populated area whose footprint is at least `gap_m` away from all others, and
  /// returns its centre; nothing after a bounded number of tries.
  std::optional<Eigen::Vector2d> find(double radius_m, double gap_m, Rng* rng);
  void add(const Eigen::Vector2d& center, double radius_m);

 private:
  struct Disc {
    Eigen::Vector2d center;
    double radius_m;
  };
  using Cell = std::pair<int, int>;
  Cell cell_of(const Eigen::Vector2d& p) const;
  bool is_free(const Eigen::Vector2d& center, double reach_m) const;

  Eigen::Vector2d min_, size_;
  double largest_radius_m_ = 0.0;
  std::map<Cell, std::vector<Disc>> cells_;
};

}  // namespace voxnav_simulation
