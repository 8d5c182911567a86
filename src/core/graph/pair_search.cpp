// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include "graph/pair_registration.hpp"

namespace voxnav::graph {
namespace {

/// Returns the first upright points of a sample. Only these determine x, y and yaw, and a prefix of a sample is spread
/// as evenly as the whole.
SurfaceSample upright_prefix(const SurfaceSample& sample, int max_points) {
  SurfaceSample out;
  out.field = sample.field;
  for (const SamplePoint& point : sample.points) {
    if (!point.is_upright) continue;
    out.points.push_back(point);
    if (out.points.size() >= static_cast<std::size_t>(max_points)) break;
  }
  return out;
}

PairOverlap all_points(const SurfaceSample& a, const SurfaceSample& b) {
  PairOverlap out;
  for (std::uint32_t i = 0; i < a.points.size(); ++i) out.of_a.push_back(i);
  for (std::uint32_t i = 0; i < b.points.size(); ++i) out.of_b.push_back(i);
  return out;
}

/// An alignment of the grid and its cost.
struct GridPose {
  Pose4 T_A_B;
  double cost;
};

int steps_within(double range, double step) { return static_cast<int>(std::ceil(range / step)); }

/// Returns T_A_B shifted by (dx, dy) and rotated about the middle of B's points. A rotation about the origin of B would
/// shift the points as well, and the steps of the grid would depend on each other.
Pose4 moved(const Pose4& T_A_B, const Eigen::Vector2d& center_B, double dx, double dy, double dyaw) {
  const geometry::Vec3 center(center_B.x(), center_B.y(), 0.0);
  const geometry::Vec3 center_A = to_pose(T_A_B) * center;
  Pose4 out = T_A_B;
  out[3] = geometry::wrap_angle(T_A_B[3] + dyaw);
  const Pose4 turn_only(0.0, 0.0, 0.0, out[3]);
  out.head<3>() = center_A - to_pose(turn_only) * center + geometry::Vec3(dx, dy, 0.0);
  return out;
}

struct PointsExtent {
  Eigen::Vector2d center;
  double radius_m;
};

PointsExtent extent_of(const SurfaceSample& sample) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const SamplePoint& point : sample.points) mean += point.position_S.head<2>();
  mean /= static_cast<double>(sample.points.size());
  double spread = 0.0;
  for (const SamplePoint& point : sample.points) spread += (point.position_S.head<2>() - mean).squaredNorm();
  return {mean, std::max(1.0, std::sqrt(spread / static_cast<double>(sample.points.size())))};
}

std::vector<GridPose> score_grid(const SurfaceSample& a, const SurfaceSample& b, const Pose4& T_A_B,
                                 const PairSearch& search) {
  const PointsExtent extent = extent_of(b);
  const PairOverlap everything = all_points(a, b);
  const double step_rad = search.step_m / extent.radius_m;
  const int n_xy = steps_within(search.range_m, search.step_m);
  const int n_yaw = std::min(steps_within(search.range_rad, step_rad), 45);
  std::vector<GridPose> out;
  // An alignment that costs clearly more than the best so far can neither win nor keep the winner from standing out.
  double enough = std::numeric_limits<double>::infinity();
  for (int k = -n_yaw; k <= n_yaw; ++k) {
    for (int j = -n_xy; j <= n_xy; ++j) {
      for (int i = -n_xy; i <= n_xy; ++i) {
        const Pose4 T = moved(T_A_B, extent.center, i * search.step_m, j * search.step_m, k * step_rad);
        out.push_back({T, cost_up_to(a, b, everything, T, search.step_m, enough)});
        if (search.min_advantage > 0.0) enough = std::min(enough, out.back().cost / search.min_advantage);
      }
    }
  }
  return out;
}

}  // namespace

std::optional<Pose4> search_pair(const SurfaceSample& full_a, const SurfaceSample& full_b, const Pose4& T_A_B,
                                 const PairSearch& search) {
  constexpr std::size_t kMinPoints = 20;
  const SurfaceSample a = upright_prefix(full_a, search.max_points);
  const SurfaceSample b = upright_prefix(full_b, search.max_points);
  if (a.points.size() < kMinPoints || b.points.size() < kMinPoints) return std::nullopt;
  const std::vector<GridPose> grid = score_grid(a, b, T_A_B, search);
  const auto best =
      std::min_element(grid.begin(), grid.end(), [](const GridPose& l, const GridPose& r) { return l.cost < r.cost; });
  double elsewhere = std::numeric_limits<double>::infinity();
  const double near_rad = 2.0 * search.step_m / extent_of(b).radius_m;
  for (const GridPose& candidate : grid) {
    const bool is_near = (candidate.T_A_B - best->T_A_B).head<2>().norm() < 2.5 * search.step_m &&
                         std::abs(geometry::wrap_angle(candidate.T_A_B[3] - best->T_A_B[3])) <= near_rad;
    if (!is_near) elsewhere = std::min(elsewhere, candidate.cost);
  }
  if (best->cost > search.min_advantage * elsewhere) return std::nullopt;
  return best->T_A_B;
}

}  // namespace voxnav::graph
