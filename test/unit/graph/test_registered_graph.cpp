// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "graph/pose4.hpp"
#include "grid_field.hpp"
#include "voxnav/graph/submap_graph.hpp"

using namespace voxnav::graph;         // NOLINT: test
using namespace voxnav::test_support;  // NOLINT: test

namespace {

Matrix4 information_of(const Pose4& sigma) { return Matrix4(sigma.cwiseProduct(sigma).cwiseInverse().asDiagonal()); }

const Pose4 kSigma(0.25, 0.25, 0.1, 0.01);

/// A flight along a ring, which ends where it began with odometry that has drifted.
struct Flight {
  std::vector<Pose4> truth;
  std::vector<Pose4> odometry;
  std::vector<std::shared_ptr<GridField>> submaps;
};

Flight ring_flight(const ForestWorld& world, int count, double radius_m, const Pose4& drift_per_step) {
  Flight flight;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * M_PI * i / (count - 1);
    flight.truth.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), 2.0,
                              voxnav::geometry::wrap_angle(angle + M_PI / 2));
    if (i == 0) {
      flight.odometry.push_back(flight.truth[0]);
    } else {
      const Pose4 step = relative(flight.truth[flight.truth.size() - 2], flight.truth.back()) + drift_per_step;
      flight.odometry.push_back(compose(flight.odometry.back(), step));
    }
    View view;
    view.seed = static_cast<unsigned>(i) + 1;
    flight.submaps.push_back(make_submap(world, to_pose(flight.truth.back()), view));
  }
  return flight;
}

SubmapGraph graph_of(const Flight& flight) {
  SubmapGraph graph;
  for (std::size_t i = 0; i < flight.truth.size(); ++i) {
    const int id = static_cast<int>(i);
    graph.add_submap(id, to_pose(flight.odometry[i]), flight.submaps[i]);
    if (i == 0) continue;
    graph.add_relative_pose(id - 1, id, to_pose(relative(flight.odometry[i - 1], flight.odometry[i])),
                            information_of(kSigma), ConstraintKind::kOdometry);
  }
  return graph;
}

double rmse(const SubmapGraph& graph, const std::vector<Pose4>& truth) {
  double sum = 0.0;
  for (const auto& [id, pose] : graph.poses()) {
    sum += (pose.translation() - truth[static_cast<std::size_t>(id)].head<3>()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

double rmse(const std::vector<Pose4>& poses, const std::vector<Pose4>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) sum += (poses[i] - truth[i]).head<3>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

const Flight& forest_flight() {
  static const Flight flight = ring_flight(make_forest(60, 300, 9), 17, 20.0, Pose4(0.08, 0.1, 0.03, 0.004));
  return flight;
}

}  // namespace

TEST(RegisteredGraph, RevisitInForestIsPulledTogether) {
  const Flight& flight = forest_flight();
  SubmapGraph graph = graph_of(flight);
  const double before = rmse(flight.odometry, flight.truth);
  const OptimizeReport report = graph.optimize();
  EXPECT_GT(before, 0.8);
  EXPECT_LT(rmse(graph, flight.truth), 0.12);
  EXPECT_GT(report.num_pairs, 20);
  EXPECT_LE(report.cost_after, report.cost_before);
}

TEST(RegisteredGraph, SecondSolveIsWarm) {
  const Flight& flight = forest_flight();
  SubmapGraph graph = graph_of(flight);
  graph.optimize();
  const OptimizeReport again = graph.optimize();
  EXPECT_LE(again.num_pair_evaluations, 4 * again.num_pairs);
  EXPECT_LE(again.cost_after, again.cost_before);
  EXPECT_LT(rmse(graph, flight.truth), 0.12);
}

TEST(RegisteredGraph, GrowsSubmapBySubmapWithinItsBudget) {
  const Flight& flight = forest_flight();
  SubmapGraph graph;
  for (std::size_t i = 0; i < flight.truth.size(); ++i) {
    const int id = static_cast<int>(i);
    // As in flight, a new submap starts relative to the corrected pose of the submap before it.
    Pose4 start = flight.odometry[i];
    if (i > 0) {
      const Pose4 step = relative(flight.odometry[i - 1], flight.odometry[i]);
      start = compose(to_pose4(graph.poses().at(id - 1), "pose"), step);
      graph.add_submap(id, to_pose(start), flight.submaps[i]);
      graph.add_relative_pose(id - 1, id, to_pose(step), information_of(kSigma), ConstraintKind::kOdometry);
    } else {
      graph.add_submap(id, to_pose(start), flight.submaps[i]);
    }
    const OptimizeReport report = graph.optimize();
    EXPECT_LE(report.num_new_pairs, 2 * static_cast<int>(i) + 2);
    EXPECT_LE(report.num_pair_evaluations, 16 * report.num_pairs + 16);
  }
  EXPECT_LT(rmse(graph, flight.truth), 0.12);
}

TEST(RegisteredGraph, RepeatsBitByBit) {
  const Flight& flight = forest_flight();
  SubmapGraph first = graph_of(flight);
  SubmapGraph second = graph_of(flight);
  first.optimize();
  second.optimize();
  for (const auto& [id, pose] : first.poses()) EXPECT_EQ(pose.matrix(), second.poses().at(id).matrix());
}

TEST(RegisteredGraph, MovesWithTheFrame) {
  const Flight& flight = forest_flight();
  Flight moved = flight;
  const Pose4 frame(30, -20, 4, 0.9);
  for (Pose4& pose : moved.odometry) pose = compose(frame, pose);
  SubmapGraph here = graph_of(flight);
  SubmapGraph there = graph_of(moved);
  here.optimize();
  there.optimize();
  // The spatial index is aligned with the frame and may propose other pairs, so results agree only within noise.
  for (const auto& [id, pose] : here.poses()) {
    const Pose expected = to_pose(frame) * pose;
    EXPECT_LT((there.poses().at(id).translation() - expected.translation()).norm(), 0.05) << id;
  }
}

TEST(RegisteredGraph, MeadowIsNeverWorseAndKeepsOdometryInThePlane) {
  ForestWorld meadow;
  meadow.hill_m = 0.2;
  const Flight flight = ring_flight(meadow, 12, 15.0, Pose4(0.02, 0.03, 0.04, 0.002));
  SubmapGraph graph = graph_of(flight);
  const OptimizeReport report = graph.optimize();
  EXPECT_GT(report.num_pairs, 10);
  EXPECT_LE(rmse(graph, flight.truth), 1.02 * rmse(flight.odometry, flight.truth));
  for (const auto& [id, pose] : graph.poses()) {
    EXPECT_NEAR(pose.translation().z(), 2.0, 0.15);
  }
}

TEST(RegisteredGraph, PerfectInputIsNotChanged) {
  Flight flight = forest_flight();
  flight.odometry = flight.truth;
  SubmapGraph graph = graph_of(flight);
  graph.optimize();
  EXPECT_LT(rmse(graph, flight.truth), 0.04);
}

TEST(RegisteredGraph, WrongLoopIsRejectedAmongRegisteredSubmaps) {
  const Flight& flight = forest_flight();
  SubmapGraph graph = graph_of(flight);
  graph.add_relative_pose(2, 10, to_pose(Pose4(1, 1, 0, 0.3)), information_of({0.1, 0.1, 0.1, 0.02}),
                          ConstraintKind::kLoop);
  const OptimizeReport report = graph.optimize();
  EXPECT_EQ(report.rejected_loops.size(), 1u);
  EXPECT_LT(rmse(graph, flight.truth), 0.12);
}
