// SPDX-License-Identifier: BSD-3-Clause
#include "ground_plan.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav_simulation {
namespace {

constexpr double kCellM = 4.0;
constexpr int kMaxTries = 200;

}  // namespace

GroundPlan::GroundPlan(const WorldConfig& config)
    : min_(config.min_corner_m[0], config.min_corner_m[1]), size_(config.size_m[0], config.size_m[1]) {}

GroundPlan::Cell GroundPlan::cell_of(const Eigen::Vector2d& p) const {
  return {static_cast<int>(std::floor(p.x() / kCellM)), static_cast<int>(std::floor(p.y() / kCellM))};
}

void GroundPlan::add(const Eigen::Vector2d& center, double radius_m) {
  cells_[cell_of(center)].push_back({center, radius_m});
  largest_radius_m_ = std::max(largest_radius_m_, radius_m);
}

bool GroundPlan::is_free(const Eigen::Vector2d& center, double reach_m) const {
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(reach_m + largest_radius_m_);
  const Cell low = cell_of(center - reach), high = cell_of(center + reach);
  for (int x = low.first; x <= high.first; ++x) {
    for (int y = low.second; y <= high.second; ++y) {
      const auto cell = cells_.find({x, y});
      if (cell == cells_.end()) continue;
      for (const Disc& disc : cell->second) {
        if ((disc.center - center).norm() < disc.radius_m + reach_m) return false;
      }
    }
  }
  return true;
}

std::optional<Eigen::Vector2d> GroundPlan::find(double radius_m, double gap_m, Rng* rng) {
  for (int i = 0; i < kMaxTries; ++i) {
    const double x = rng->uniform(), y = rng->uniform();
    const Eigen::Vector2d center = min_ + Eigen::Vector2d(x, y).cwiseProduct(size_);
    if (!is_free(center, radius_m + gap_m)) continue;
    add(center, radius_m);
    return center;
  }
  return std::nullopt;
}

}  // namespace voxnav_simulation
