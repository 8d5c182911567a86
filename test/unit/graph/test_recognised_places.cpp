// SPDX-License-Identifier: BSD-3-Clause
// Flights that return to the grove where they began, over a meadow on which nothing corrects the drift.
#include <gtest/gtest.h>

#include "graph/pose4.hpp"
#include "grid_field.hpp"
#include "voxnav/graph/submap_graph.hpp"

using namespace voxnav::graph;         // NOLINT: test
using namespace voxnav::test_support;  // NOLINT: test

namespace {

struct Flight {
  std::vector<Pose4> truth;
  std::vector<Pose4> odometry;
  std::vector<std::shared_ptr<GridField>> submaps;
};

/// Returns a world with trees around the origin only. The rest is a meadow, which determines nothing but height.
ForestWorld grove(unsigned seed) {
  ForestWorld world = make_forest(32, 250, seed);
  world.hill_m = 0.1;
  return world;
}

/// Returns a path through the grove along x, over the meadow in a wide curve, and back through the grove.
std::vector<Pose4> there_and_back() {
  std::vector<Pose4> out;
  out.reserve(26);
  for (int i = 0; i < 6; ++i) out.emplace_back(-15.0 + 6.0 * i, 0.0, 2.0, 0.1);
  for (int i = 1; i < 14; ++i) {
    const double angle = M_PI * i / 13.0 - 0.5 * M_PI;
    out.emplace_back(40.0 + 80.0 * std::cos(angle), 60.0 + 60.0 * std::sin(angle), 2.0, angle + 0.5 * M_PI);
  }
  out.emplace_back(60.0, 70.0, 2.0, -2.5);
  for (int i = 0; i < 6; ++i) out.emplace_back(15.0 - 6.0 * i, 3.0, 2.0, M_PI - 0.2);
  return out;
}

/// Returns a flight whose odometry drifts in a constant direction of W, so that the way back does not undo the drift.
Flight fly(const ForestWorld& world, const Pose4& drift_per_step) {
  Flight flight;
  flight.truth = there_and_back();
  for (std::size_t i = 0; i < flight.truth.size(); ++i) {
    flight.odometry.emplace_back(flight.truth[i] + static_cast<double>(i) * drift_per_step);
    View view;
    view.range_m = 18.0;
    view.seed = static_cast<unsigned>(i) + 1;
    flight.submaps.push_back(make_submap(world, to_pose(flight.truth[i]), view));
  }
  return flight;
}

struct Result {
  double drift_m = 0.0;  ///< error of odometry at the end of the flight
  double left_m = 0.0;   ///< error at the end of the flight after all solves
  int num_recognised = 0;
};

Result solve(const Flight& flight, const SubmapGraphConfig& config) {
  SubmapGraph graph(config);
  const Matrix4 information = Pose4(0.5, 0.5, 0.1, 0.02).array().square().inverse().matrix().asDiagonal();
  Result out;
  for (std::size_t i = 0; i < flight.truth.size(); ++i) {
    const int id = static_cast<int>(i);
    Pose4 start = flight.odometry[0];
    if (i > 0) {
      const Pose4 step = relative(flight.odometry[i - 1], flight.odometry[i]);
      start = compose(to_pose4(graph.poses().at(id - 1), "pose"), step);
      graph.add_submap(id, to_pose(start), flight.submaps[i]);
      graph.add_relative_pose(id - 1, id, to_pose(step), information, ConstraintKind::kOdometry);
    } else {
      graph.add_submap(id, to_pose(start), flight.submaps[i]);
    }
    out.num_recognised += graph.optimize().num_recognised;
  }
  const Vec3 end = flight.truth.back().head<3>();
  out.drift_m = (flight.odometry.back().head<3>() - end).norm();
  out.left_m = (graph.poses().rbegin()->second.translation() - end).norm();
  return out;
}

const Pose4 kDriftPerStep(0.35, 0.3, 0.02, 0.004);

}  // namespace

TEST(RecognisedPlaces, TenMetresOfDriftAreClosedWithReversedHeading) {
  for (const unsigned seed : {1u, 2u}) {
    const Flight flight = fly(grove(seed), kDriftPerStep);
    const Result with = solve(flight, {});
    EXPECT_GT(with.drift_m, 10.0);
    EXPECT_GE(with.num_recognised, 2) << "seed " << seed;
    EXPECT_LT(with.left_m, 0.2) << "seed " << seed;
    SubmapGraphConfig off;
    off.is_place_recognition_enabled = false;
    EXPECT_GT(solve(flight, off).left_m, 2.0) << "seed " << seed;
  }
}

TEST(RecognisedPlaces, AnotherGroveIsNotMistakenForTheFirst) {
  for (const unsigned seed : {1u, 2u}) {
    Flight flight = fly(grove(seed), kDriftPerStep);
    const Flight other = fly(grove(seed + 10), kDriftPerStep);
    std::copy(other.submaps.end() - 6, other.submaps.end(), flight.submaps.end() - 6);
    EXPECT_EQ(solve(flight, {}).num_recognised, 0) << "seed " << seed;
  }
}
