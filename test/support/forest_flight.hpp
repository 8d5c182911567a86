// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::test {

/// An endless forest on flat ground with one tree per square of 6 m, every other one with a crown.
class Forest {
 public:
  struct Tree {
    geometry::Vec3 foot;
    double radius;
    double crown_radius;  ///< 0 = no crown
  };

  static Tree tree_at(int cx, int cy) {
    std::mt19937 rng(static_cast<unsigned>(cx * 7349 + cy * 9151 + 1000003));
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const double x = kCell * (cx + 0.1 + 0.8 * unit(rng));
    const double y = kCell * (cy + 0.1 + 0.8 * unit(rng));
    const double radius = 0.05 + 0.35 * unit(rng);
    return {{x, y, 0.0}, radius, unit(rng) < 0.5 ? 0.0 : 1.0 + 1.5 * unit(rng)};
  }
  static std::vector<Tree> trees_near(const geometry::Vec3& p, double reach) {
    std::vector<Tree> out;
    for (int cy = static_cast<int>(std::floor((p.y() - reach) / kCell)); cy * kCell < p.y() + reach; ++cy) {
      for (int cx = static_cast<int>(std::floor((p.x() - reach) / kCell)); cx * kCell < p.x() + reach; ++cx) {
        const Tree tree = tree_at(cx, cy);
        const double gap = (tree.foot - p).head<2>().norm();
        if (gap > 1.5 && gap < reach) out.push_back(tree);
      }
    }
    return out;
  }
  /// Returns the range along a unit direction, or 0 if nothing is within max_range_m.
  static double range(const geometry::Vec3& from, const geometry::Vec3& direction, const std::vector<Tree>& trees,
                      double max_range_m) {
    double range = direction.z() < 0.0 ? -from.z() / direction.z() : 1e9;
    const double a = direction.head<2>().squaredNorm();
    for (const Tree& tree : trees) {
      const geometry::Vec3 to = tree.foot - from;
      const double b = direction.head<2>().dot(to.head<2>());
      const double cross = direction.x() * to.y() - direction.y() * to.x();
      const double widest = std::max(tree.radius, tree.crown_radius);
      if (b <= 0.0 || cross * cross > a * widest * widest) continue;
      const double trunk = b * b - a * (to.head<2>().squaredNorm() - tree.radius * tree.radius);
      const double hit = trunk >= 0.0 ? (b - std::sqrt(trunk)) / a : -1.0;
      if (hit > 0.0 && from.z() + hit * direction.z() < 9.0) range = std::min(range, hit);
      const geometry::Vec3 to_crown = to + geometry::Vec3(0, 0, 8.0);
      const double along = direction.dot(to_crown);
      const double crown = along * along - to_crown.squaredNorm() + tree.crown_radius * tree.crown_radius;
      if (crown > 0.0 && along - std::sqrt(crown) > 0.0) range = std::min(range, along - std::sqrt(crown));
    }
    return range < max_range_m ? range : 0.0;
  }

 private:
  static constexpr double kCell = 6.0;
};

/// Returns one sweep of 128 beams over 90 degrees as rows of x, y, z in the sensor frame.
inline std::vector<float> forest_scan(const geometry::Vec3& from, double yaw, int columns = 512,
                                      double noise_m = 0.02) {
  const std::vector<Forest::Tree> trees = Forest::trees_near(from, 60.0);
  std::mt19937 rng(static_cast<unsigned>(std::lround(1000 * from.x() + 77 * from.y())));
  std::normal_distribution<double> noise(0.0, noise_m);
  std::vector<float> out;
  for (int column = 0; column < columns; ++column) {
    const double azimuth = column * (2.0 * 3.14159265358979 / columns);
    const geometry::Vec3 ahead(std::cos(azimuth + yaw), std::sin(azimuth + yaw), 0.0);
    std::vector<Forest::Tree> candidates;
    for (const Forest::Tree& tree : trees) {
      const geometry::Vec3 to = tree.foot - from;
      const double widest = std::max(tree.radius, tree.crown_radius);
      if (ahead.dot(to) > 0.0 && std::abs(ahead.x() * to.y() - ahead.y() * to.x()) < widest) candidates.push_back(tree);
    }
    for (int row = 0; row < 128; ++row) {
      const double elevation = (45.0 - row * (90.0 / 127.0)) * 3.14159265358979 / 180.0;
      const geometry::Vec3 direction = ahead * std::cos(elevation) + geometry::Vec3(0, 0, std::sin(elevation));
      const double range = Forest::range(from, direction, candidates, 60.0);
      if (range <= 0.0) continue;
      const double measured = range + noise(rng);
      const geometry::Vec3 d_L(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                               std::sin(elevation));
      for (int axis = 0; axis < 3; ++axis) out.push_back(static_cast<float>(d_L[axis] * measured));
    }
  }
  return out;
}

struct FlownSubmap {
  geometry::Pose T_O_S;
  occupancy::MapContent content;
};

/// Returns the submaps of a flight that goes east and comes back beside its own path, 11 m for each submap.
inline std::vector<FlownSubmap> forest_flight(int num_submaps, double resolution_m = 0.4) {
  occupancy::LocalMapConfig config;
  config.resolution_m = resolution_m;
  occupancy::LocalMap map(config);
  std::vector<FlownSubmap> out;
  constexpr int kScans = 10;
  const int turn = (num_submaps + 1) / 2 * kScans;
  for (int i = 0; i < num_submaps * kScans; ++i) {
    const bool is_back = i >= turn;
    const double x = 1.1 * (is_back ? 2 * turn - i : i);
    const geometry::Pose T_O_L = geometry::from_position_yaw({x, is_back ? 8.0 : 0.0, 3.0}, is_back ? 3.0 : 0.1);
    const std::vector<float> points = forest_scan(T_O_L.translation(), is_back ? 3.0 : 0.1);
    for (int repeat = 0; repeat < 3; ++repeat) map.insert(geometry::view_of_rows(points), T_O_L);
    if (i % kScans == kScans - 1) {
      occupancy::MapContent content = map.take_evicted();
      content.merge(map.hand_over());
      out.push_back({geometry::gravity_aligned(T_O_L), std::move(content)});
    }
  }
  return out;
}

}  // namespace voxnav::test
