// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "voxnav_simulation/trajectory_generator.hpp"

namespace uav_test {

using voxnav_simulation::HeadedPoint;
using voxnav_simulation::TrackerLimits;
using voxnav_simulation::Vec3;

inline std::vector<Vec3> differences(const std::vector<Vec3>& in, double dt_s) {
  std::vector<Vec3> out;
  for (std::size_t i = 0; i + 1 < in.size(); ++i) out.emplace_back((in[i + 1] - in[i]) / dt_s);
  return out;
}

/// The largest shares of their limits that speed, acceleration and jerk reach, from finite differences of positions.
struct Usage {
  double speed = 0;
  double acceleration = 0;
  double jerk = 0;
  double worst() const { return std::max({speed, acceleration, jerk}); }
};

inline double share(const std::vector<Vec3>& values, double horizontal, double up, double down) {
  double worst = 0;
  for (const Vec3& v : values) {
    worst = std::max({worst, v.head<2>().norm() / horizontal, v.z() / up, -v.z() / down});
  }
  return worst;
}

inline Usage usage(const std::vector<Vec3>& positions, double dt_s, const TrackerLimits& l) {
  const auto v = differences(positions, dt_s);
  const auto a = differences(v, dt_s);
  const auto j = differences(a, dt_s);
  return {share(v, l.horizontal.speed, l.ascending.speed, l.descending.speed),
          share(a, l.horizontal.acceleration, l.ascending.acceleration, l.descending.acceleration),
          share(j, l.horizontal.jerk, l.ascending.jerk, l.descending.jerk)};
}

inline double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double squared = (b - a).squaredNorm();
  const double t = squared > 0 ? std::clamp((p - a).dot(b - a) / squared, 0.0, 1.0) : 0.0;
  return (a + t * (b - a) - p).norm();
}

inline double distance_to_path(const Vec3& p, const std::vector<HeadedPoint>& path) {
  double best = (p - path.front().position).norm();
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    best = std::min(best, distance_to_segment(p, path[i].position, path[i + 1].position));
  }
  return best;
}

inline std::vector<HeadedPoint> random_path(std::mt19937* random, int count, double step_m) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<HeadedPoint> out{{Vec3(0, 0, 5), 0}};
  for (int i = 0; i < count; ++i) {
    const Vec3 step(unit(*random) * step_m, unit(*random) * step_m, unit(*random) * 0.3 * step_m);
    out.push_back({out.back().position + step, unit(*random) * 3});
  }
  return out;
}

}  // namespace uav_test
