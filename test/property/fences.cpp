// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/fences.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <queue>
#include <random>
#include <set>

#include "box_grid.hpp"
#include "voxnav/pipeline/navigation_map.hpp"
#include "voxnav/pipeline/planning_manager.hpp"
#include "voxnav/planning/a_star.hpp"
#include "voxnav/planning/corridor.hpp"
#include "voxnav/planning/path_planner.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Index3;
using geometry::Vec3;
using planning::FenceKind;
using planning::Fences;
using planning::PlanStatus;
using planning::Prism;
using planning::UnknownPolicy;

namespace {

constexpr double kResolution = 0.5;
constexpr double kSafety = 0.6;
constexpr double kAreaMargin = 0.3, kZoneDistance = 0.8;
constexpr int kCells = 56, kHeights = 16;  // a hall of 28 x 28 x 8 m

/// Whether a point is inside a polygon, by the angle under which it sees the outline.
bool is_in_outline(const Prism& prism, const Vec3& p) {
  double angle = 0.0;
  for (std::size_t i = 0; i < prism.outline.size(); ++i) {
    const Eigen::Vector2d a = prism.outline[i] - p.head<2>();
    const Eigen::Vector2d b = prism.outline[(i + 1) % prism.outline.size()] - p.head<2>();
    angle += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  return std::abs(angle) > 3.0;
}

/// Distance from the edges of the outline, along which the nearest point is where the direction is at a right angle.
double distance_from_outline(const Prism& prism, const Vec3& p) {
  double least = 1e9;
  for (std::size_t i = 0; i < prism.outline.size(); ++i) {
    const Eigen::Vector2d a = prism.outline[i] - p.head<2>();
    const Eigen::Vector2d b = prism.outline[(i + 1) % prism.outline.size()] - p.head<2>();
    least = std::min({least, a.norm(), b.norm()});
    const Eigen::Vector2d along = (b - a).normalized();
    if (a.dot(along) < 0.0 && b.dot(along) > 0.0)
      least = std::min(least, std::abs(a.x() * along.y() - a.y() * along.x()));
  }
  return least;
}

double room_in(const Prism& area, const Vec3& p) {
  const double side = is_in_outline(area, p) ? distance_from_outline(area, p) : -distance_from_outline(area, p);
  return std::min({side, p.z() - area.min_z, area.max_z - p.z()});
}

double room_from(const Prism& zone, const Vec3& p) {
  const double side = is_in_outline(zone, p) ? 0.0 : distance_from_outline(zone, p);
  return std::hypot(side, std::max({0.0, zone.min_z - p.z(), p.z() - zone.max_z}));
}

/// A hall with posts, an area in it of a ragged outline, and ragged zones, some of them over or below the flight.
class Scene {
 public:
  explicit Scene(int seed) : rng_(static_cast<unsigned>(seed)) {
    grid = test::box_grid({0, 0, 0}, {kCells - 1, kCells - 1, kHeights - 1}, kResolution);
    for (int i = 0; i < 8; ++i) {
      const int x = static_cast<int>(rng_() % kCells), y = static_cast<int>(rng_() % kCells);
      test::fill(grid.get(), {x, y, 0}, {x, y, kHeights - 1}, containers::VoxelState::kOccupied);
    }
    if (seed % 5 != 4) area = ragged({14, 14}, 7.0, 16.0, 0.5, 7.5);
    for (int i = 0; i < 4; ++i) {
      const double low = uniform(-1.0, 5.0);
      zones.push_back(ragged({uniform(6, 22), uniform(6, 22)}, 1.0, 4.0, low, low + uniform(3.0, 12.0)));
    }
    fences = std::make_shared<Fences>(area, zones);
  }

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng_); }
  Vec3 point() { return {uniform(0, 28), uniform(0, 28), uniform(0.5, 7.5)}; }

  /// How much more than the margins a place keeps.
  double room(const Vec3& p, double area_margin, double zone_distance) const {
    double least = area ? room_in(*area, p) - area_margin : 1e9;
    for (const Prism& zone : zones) least = std::min(least, room_from(zone, p) - zone_distance);
    return least;
  }

  std::shared_ptr<const planning::OccupancyView> view(const Vec3& vehicle) const {
    pipeline::NavigationMapConfig config;
    config.min_altitude_m = 0.0;
    config.max_altitude_m = 8.0;
    config.footprint_radius_m = config.footprint_half_height_m = 0.0;
    config.area_margin_m = kAreaMargin;
    config.zone_distance_m = kZoneDistance;
    pipeline::NavigationMap map(config);
    map.apply_local(containers::snapshot_of(*grid), 1, kResolution);
    map.set_T_W_O(geometry::Pose::Identity());
    map.set_vehicle(vehicle);
    map.set_fences(fences);
    return map.view();
  }

  std::shared_ptr<containers::StateGrid> grid;
  std::optional<Prism> area;
  std::vector<Prism> zones;
  std::shared_ptr<const Fences> fences;

 private:
  /// A polygon around a middle, whose corners are nearer or farther by turns of chance.
  Prism ragged(const Eigen::Vector2d& middle, double near, double far, double min_z, double max_z) {
    Prism out;
    out.min_z = min_z;
    out.max_z = max_z;
    const int n = 3 + static_cast<int>(rng_() % 8);
    for (int i = 0; i < n; ++i) {
      const double angle = 2.0 * M_PI * (i + uniform(0.0, 0.8)) / n, radius = uniform(near, far);
      out.outline.emplace_back(middle.x() + radius * std::cos(angle), middle.y() + radius * std::sin(angle));
    }
    if (rng_() % 2 == 0) std::reverse(out.outline.begin(), out.outline.end());
    return out;
  }

  std::mt19937 rng_;
};

/// Whether a path may surely enter a cell: there is a little more room than the margins, and posts are far.
bool is_sure(const Scene& scene, const Index3& cell) {
  const auto inside = [](int v, int size) { return v >= 0 && v < size; };
  if (!inside(cell.x, kCells) || !inside(cell.y, kCells) || !inside(cell.z, kHeights)) return false;
  for (int y = -2; y <= 2; ++y) {
    for (int x = -2; x <= 2; ++x) {
      if (scene.grid->state(cell + Index3{x, y, 0}) == containers::VoxelState::kOccupied) return false;
    }
  }
  // The whole cube keeps a margin that its centre keeps by half its diagonal more.
  const Vec3 center = geometry::center_of(cell, kResolution);
  return scene.room(center, kAreaMargin, kZoneDistance) > std::sqrt(0.75) * kResolution + 1e-6;
}

/// Whether cells with common faces that may surely be entered lead from one point to another.
bool connects(const Scene& scene, const Vec3& from, const Vec3& to) {
  const Index3 start = geometry::index_of(from, kResolution), goal = geometry::index_of(to, kResolution);
  if (!is_sure(scene, start) || !is_sure(scene, goal)) return false;
  std::set<Index3> seen = {start};
  std::queue<Index3> open;
  for (open.push(start); !open.empty(); open.pop()) {
    if (open.front() == goal) return true;
    for (const Index3& step : {Index3{1, 0, 0}, Index3{0, 1, 0}, Index3{0, 0, 1}}) {
      for (const Index3& next : {open.front() + step, open.front() - step}) {
        if (seen.insert(next).second && is_sure(scene, next)) open.push(next);
      }
    }
  }
  return false;
}

planning::PathPlannerConfig config_of(int seed) {
  planning::PathPlannerConfig config;
  config.quick = seed % 2 == 0;
  config.suboptimality_bound = config.quick ? 1.2 : 1.05;
  config.unknown_policy = seed % 3 == 0 ? UnknownPolicy::kPenalise : UnknownPolicy::kForbid;
  config.unknown_cost = 1.1;
  config.goal_search_radius_m = 3.0;
  return config;
}

planning::AnyAnglePlan plan(const Scene& scene, int seed, const Vec3& start, const Vec3& goal) {
  planning::ClearanceFieldConfig config;
  config.safety_distance_m = kSafety;
  config.unknown_is_flyable = seed % 3 == 0;
  planning::ClearanceField field(config);
  field.update(*scene.view(start));
  return planning::PathPlanner(config_of(seed)).plan(field, start, goal);
}

/// The least room that a path keeps beyond margins, at samples of 5 cm.
double least_room(const Scene& scene, const std::vector<Vec3>& path, double area_margin, double zone_distance) {
  double least = 1e9;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const int n = 1 + static_cast<int>((path[i] - path[i - 1]).norm() / 0.05);
    for (int k = 0; k <= n; ++k) {
      const Vec3 p = path[i - 1] + (path[i] - path[i - 1]) * k / n;
      least = std::min(least, scene.room(p, area_margin, zone_distance));
    }
  }
  return least;
}

}  // namespace

TEST(FencesProperty, PathsKeepTheMarginsAndExistWhereBruteForceFindsThem) {
  int num_paths = 0, num_round = 0, num_refused = 0;
  for (int seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene scene(seed);
    for (int trial = 0; trial < 7; ++trial) {
      const Vec3 start = scene.point(), goal = scene.point();
      const auto found = plan(scene, seed, start, goal);
      if (scene.room(start, 0.0, 0.0) <= 0.0) {
        ASSERT_EQ(found.status, PlanStatus::kStartFenced);
        ASSERT_TRUE(found.path.empty());
        continue;
      }
      if (scene.room(goal, 0.0, 0.0) <= 0.0) {
        ++num_refused;
        ASSERT_TRUE(found.status == PlanStatus::kGoalFenced || found.status == PlanStatus::kStartBlocked);
        ASSERT_TRUE(found.path.empty());
        continue;
      }
      if (connects(scene, start, goal)) {
        ASSERT_EQ(found.status, PlanStatus::kComplete) << explain(found.status);
        ++num_paths;
        num_round += found.length_m > 1.02 * (goal - start).norm();
      }
      // A start within the margins is left first, over cells whose centres violate no fence.
      const bool is_plain = scene.room(start, kAreaMargin, kZoneDistance) > std::sqrt(3.0) * kResolution;
      if (is_plain) {
        ASSERT_GE(least_room(scene, found.path, kAreaMargin, kZoneDistance), -1e-6);
      }
    }
  }
  EXPECT_GT(num_paths, 20);
  EXPECT_GT(num_round, 5);
  EXPECT_GT(num_refused, 20);
}

TEST(FencesProperty, WhatIsToBeFlownViolatesNoFenceFromAnyStart) {
  int num_flown = 0;
  pipeline::PlanningManagerConfig manager;
  for (int seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene scene(seed);
    const Vec3 start = scene.point();
    const auto view = scene.view(start);
    planning::ClearanceFieldConfig config;
    config.safety_distance_m = 1.0;
    planning::ClearanceField field(config);
    field.update(*view);
    const planning::DynamicsLimits limits{4.0, 2.0, 2.0, 1.0, 2.0, 1.0};
    for (int trial = 0; trial < 4; ++trial) {
      const pipeline::PlanTask task{start, scene.point(), limits};
      const auto outcome = pipeline::run_plan_job(planning::PathPlanner(config_of(1)), field, manager, *view, task);
      if (outcome.waypoints_O.empty()) continue;
      ++num_flown;
      ASSERT_GE(least_room(scene, outcome.waypoints_O, 0.0, std::min(0.5, outcome.corridor_radius_m)), -1e-6);
    }
  }
  EXPECT_GT(num_flown, 30);
}

TEST(FencesProperty, TheLatticeSearchKeepsTheMarginsToo) {
  int num_paths = 0;
  planning::AStarConfig config;
  config.safety_distance_m = kSafety;
  config.timeout_s = 60.0;
  config.simplify = true;
  for (int seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene scene(seed);
    const Vec3 start = scene.point(), goal = scene.point();
    if (scene.room(start, kAreaMargin, kZoneDistance) < std::sqrt(3.0) * kResolution) continue;
    const auto found = planning::AStarPlanner(config).plan(*scene.view(start), start, goal);
    const bool is_fenced = scene.room(goal, 0.0, 0.0) <= 0.0;
    if (is_fenced && found.status != PlanStatus::kStartBlocked) {
      ASSERT_EQ(found.status, PlanStatus::kGoalFenced);
    }
    ASSERT_GE(least_room(scene, found.path, kAreaMargin, kZoneDistance), -1e-6);
    num_paths += !found.path.empty();
  }
  EXPECT_GT(num_paths, 2);
}

TEST(FencesProperty, TouchesAreWhereSamplingFindsThem) {
  int num_touches = 0;
  for (int seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene scene(seed);
    const Vec3 from = scene.point(), to = scene.point();
    const double radius = seed % 3 == 0 ? 0.0 : scene.uniform(0.0, 1.0), length = (to - from).norm();
    const auto touch = scene.fences->first_touch(from, to, radius);
    const int n = static_cast<int>(length / 0.02) + 1;
    const double end = touch ? touch->t : 1.0;
    for (int k = 0; k <= n; ++k) {
      const double t = static_cast<double>(k) / n;
      if (t * length > end * length - 1e-9) break;
      ASSERT_GT(scene.room(from + t * (to - from), 0.0, radius), 0.0) << t;
    }
    if (!touch) continue;
    ++num_touches;
    // A little farther on, or nowhere but for the millimetre on the safe side, the fence is violated.
    const double beyond = scene.room(from + touch->t * (to - from), 0.0, radius);
    ASSERT_LT(beyond, 2e-3);
    ASSERT_EQ(touch->contact.kind == FenceKind::kArea,
              scene.area && room_in(*scene.area, from + touch->t * (to - from)) < 1e-6);
  }
  EXPECT_GT(num_touches, 100);
}
