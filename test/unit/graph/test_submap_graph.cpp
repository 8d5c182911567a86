// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "graph/pose4.hpp"
#include "voxnav/graph/submap_graph.hpp"

using namespace voxnav;         // NOLINT: test
using namespace voxnav::graph;  // NOLINT: test

namespace {

using Truth = std::vector<Pose4>;

/// Returns the true poses of submaps along a closed square, eight metres apart.
Truth square(int per_side) {
  Truth out;
  Pose4 pose = Pose4::Zero();
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < per_side; ++i) {
      out.push_back(pose);
      pose = compose(pose, Pose4(8, 0, 0, i + 1 == per_side ? M_PI / 2 : 0.0));
    }
  }
  return out;
}

struct Noise {
  Pose4 sigma{0.1, 0.1, 0.05, 0.01};
  unsigned seed = 5;
};

Matrix4 information_of(const Pose4& sigma) { return Matrix4(sigma.cwiseProduct(sigma).cwiseInverse().asDiagonal()); }

struct Odometry {
  std::vector<Pose4> steps;
  Truth poses;
};

Odometry drifting(const Truth& truth, const Noise& noise) {
  std::mt19937 rng(noise.seed);
  std::normal_distribution<double> normal;
  Odometry out;
  out.poses.push_back(truth[0]);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    Pose4 step = relative(truth[i - 1], truth[i]);
    for (int k = 0; k < 4; ++k) step[k] += noise.sigma[k] * normal(rng);
    out.steps.push_back(step);
    out.poses.push_back(compose(out.poses.back(), step));
  }
  return out;
}

SubmapGraph chain(const Odometry& odometry, const Noise& noise, const Pose4& frame = Pose4::Zero()) {
  SubmapGraph graph;
  for (std::size_t i = 0; i < odometry.poses.size(); ++i) {
    graph.add_submap(static_cast<int>(i), to_pose(compose(frame, odometry.poses[i])));
  }
  for (std::size_t i = 0; i < odometry.steps.size(); ++i) {
    graph.add_relative_pose(static_cast<int>(i), static_cast<int>(i) + 1, to_pose(odometry.steps[i]),
                            information_of(noise.sigma), ConstraintKind::kOdometry);
  }
  return graph;
}

void add_loop(SubmapGraph* graph, int a, int b, const Pose4& T_a_b) {
  graph->add_relative_pose(a, b, to_pose(T_a_b), information_of({0.05, 0.05, 0.05, 0.01}), ConstraintKind::kLoop);
}

double rmse(const SubmapGraph& graph, const Truth& truth) {
  double sum = 0.0;
  for (const auto& [id, pose] : graph.poses()) {
    sum += (pose.translation() - truth[static_cast<std::size_t>(id)].head<3>()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

const Truth kTruth = square(6);
const int kLast = static_cast<int>(kTruth.size()) - 1;

}  // namespace

TEST(SubmapGraph, OdometryAloneIsNotChanged) {
  const Odometry odometry = drifting(kTruth, Noise());
  SubmapGraph graph = chain(odometry, Noise());
  const OptimizeReport report = graph.optimize();
  EXPECT_TRUE(report.is_converged);
  EXPECT_EQ(report.num_submaps, kLast + 1);
  for (const auto& [id, pose] : graph.poses()) {
    EXPECT_LT((pose.translation() - odometry.poses[static_cast<std::size_t>(id)].head<3>()).norm(), 1e-6);
  }
}

TEST(SubmapGraph, LoopClosureLowersTheError) {
  SubmapGraph graph = chain(drifting(kTruth, Noise()), Noise());
  const double before = rmse(graph, kTruth);
  add_loop(&graph, 0, kLast, relative(kTruth[0], kTruth.back()));
  const OptimizeReport report = graph.optimize();
  EXPECT_TRUE(report.rejected_loops.empty());
  EXPECT_LT(rmse(graph, kTruth), 0.6 * before);
  EXPECT_LT(report.cost_after, report.cost_before);
  EXPECT_EQ(report.kinds[static_cast<int>(ConstraintKind::kLoop)].num_constraints, 1);
}

TEST(SubmapGraph, OneWrongLoopDoesNotBendTheMap) {
  const Odometry odometry = drifting(kTruth, Noise());
  for (const bool with_true_loop : {false, true}) {
    SubmapGraph graph = chain(odometry, Noise());
    if (with_true_loop) add_loop(&graph, 0, kLast, relative(kTruth[0], kTruth.back()));
    SubmapGraph expected = chain(odometry, Noise());
    if (with_true_loop) add_loop(&expected, 0, kLast, relative(kTruth[0], kTruth.back()));
    add_loop(&graph, 2, kLast - 2,
             compose(relative(kTruth[2], kTruth[static_cast<std::size_t>(kLast) - 2]), {9, -7, 0, 0.5}));
    const OptimizeReport report = graph.optimize();
    expected.optimize();
    ASSERT_EQ(report.rejected_loops.size(), 1u);
    EXPECT_EQ(report.rejected_loops[0].a, 2);
    EXPECT_NE(report.rejected_loops[0].reason.find("Mahalanobis"), std::string::npos);
    for (const auto& [id, pose] : graph.poses()) {
      EXPECT_LT((pose.translation() - expected.poses().at(id).translation()).norm(), 1e-6);
    }
  }
}

TEST(SubmapGraph, WrongLoopFirstDoesNotLockOutTheTrueOne) {
  // The wrong loop passes the gate of a chain with little information, but several true loops contradict it later.
  SubmapGraph graph = chain(drifting(kTruth, Noise()), Noise());
  add_loop(&graph, 1, kLast, compose(relative(kTruth[1], kTruth.back()), {1.2, 0.8, 0, 0}));
  graph.optimize();
  for (const int shift : {0, 1, 2}) {
    const int b = kLast - shift;
    add_loop(&graph, shift, b, relative(kTruth[static_cast<std::size_t>(shift)], kTruth[static_cast<std::size_t>(b)]));
  }
  const OptimizeReport report = graph.optimize();
  ASSERT_EQ(report.rejected_loops.size(), 1u);
  EXPECT_EQ(report.rejected_loops[0].a, 1);
}

TEST(SubmapGraph, SolutionMovesWithTheFrame) {
  const Odometry odometry = drifting(kTruth, Noise());
  const Pose4 frame(120, -340, 15, 2.3);
  SubmapGraph here = chain(odometry, Noise());
  SubmapGraph there = chain(odometry, Noise(), frame);
  for (SubmapGraph* graph : {&here, &there}) {
    add_loop(graph, 0, kLast, relative(kTruth[0], kTruth.back()));
    graph->optimize();
  }
  for (const auto& [id, pose] : here.poses()) {
    EXPECT_TRUE(there.poses().at(id).isApprox(to_pose(frame) * pose, 1e-6)) << id;
  }
}

TEST(SubmapGraph, OrderOfSubmapsDoesNotMatter) {
  const Odometry odometry = drifting(kTruth, Noise());
  SubmapGraph sorted = chain(odometry, Noise());
  SubmapGraph shuffled;
  std::vector<int> order(kTruth.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  for (const int id : order) shuffled.add_submap(id, to_pose(odometry.poses[static_cast<std::size_t>(id)]));
  for (const int id : order) {
    if (id == kLast) continue;
    shuffled.add_relative_pose(id, id + 1, to_pose(odometry.steps[static_cast<std::size_t>(id)]),
                               information_of(Noise().sigma), ConstraintKind::kOdometry);
  }
  for (SubmapGraph* graph : {&sorted, &shuffled}) {
    add_loop(graph, 0, kLast, relative(kTruth[0], kTruth.back()));
    graph->optimize();
  }
  for (const auto& [id, pose] : sorted.poses()) EXPECT_TRUE(shuffled.poses().at(id).isApprox(pose, 1e-7)) << id;
}

TEST(SubmapGraph, YawWrapDoesNotTearTheRing) {
  // Headings along the ring pass through pi. A start whose yaw is three full turns larger is the same start.
  Truth truth = square(4);
  const Odometry odometry = drifting(truth, Noise());
  SubmapGraph graph = chain(odometry, Noise(), Pose4(0, 0, 0, 3.0));
  add_loop(&graph, 0, 15, relative(truth[0], truth[15]));
  const OptimizeReport report = graph.optimize();
  EXPECT_TRUE(report.rejected_loops.empty());
  EXPECT_LT(report.kinds[static_cast<int>(ConstraintKind::kOdometry)].cost_after, 60.0);
}

TEST(SubmapGraph, PositionsRemoveDrift) {
  SubmapGraph graph = chain(drifting(kTruth, Noise()), Noise());
  const double before = rmse(graph, kTruth);
  const geometry::Vec3 lever(0.2, -0.1, 0.3);
  for (std::size_t i = 0; i < kTruth.size(); ++i) {
    graph.add_position(static_cast<int>(i), lever, to_pose(kTruth[i]) * lever, Eigen::Matrix3d::Identity() * 1e-4);
  }
  graph.optimize();
  EXPECT_GT(before, 0.5);
  EXPECT_LT(rmse(graph, kTruth), 0.05);
}

TEST(SubmapGraph, GnssInAnUnknownFrameRemovesDriftDespiteOutliers) {
  SubmapGraph graph = chain(drifting(kTruth, Noise()), Noise());
  const Pose4 T_G_W(5000, 300, -20, 2.0);
  for (std::size_t i = 0; i < kTruth.size(); ++i) {
    geometry::Vec3 p_G = to_pose(T_G_W) * kTruth[i].head<3>();
    if (i == 7) p_G.x() += 30.0;
    graph.add_gnss_position(static_cast<int>(i), {0, 0, 0}, p_G, Eigen::Matrix3d::Identity() * 1e-4);
  }
  for (int i = 0; i < 3; ++i) graph.optimize();
  ASSERT_TRUE(graph.gnss_datum().has_value());
  // Only the first step determines the direction of north in W, so the shape of the flight is compared, which GNSS
  // determines.
  const auto poses = graph.poses();
  for (const auto& [i, a] : poses) {
    for (const auto& [j, b] : poses) {
      if (i == 7 || j == 7) continue;
      const double expected =
          (kTruth[static_cast<std::size_t>(i)] - kTruth[static_cast<std::size_t>(j)]).head<3>().norm();
      EXPECT_NEAR((a.translation() - b.translation()).norm(), expected, 0.1) << i << " " << j;
    }
  }
}

TEST(SubmapGraph, HeightsHoldZOnly) {
  Noise noise;
  const Odometry odometry = drifting(kTruth, noise);
  SubmapGraph graph = chain(odometry, noise);
  for (int i = 0; i <= kLast; ++i) graph.add_height(i, {0, 0, 0}, 0.0, 0.01);
  graph.optimize();
  for (const auto& [id, pose] : graph.poses()) {
    EXPECT_NEAR(pose.translation().z(), 0.0, 0.02);
    EXPECT_NEAR(pose.translation().x(), odometry.poses[static_cast<std::size_t>(id)].x(), 1e-6);
  }
}

TEST(SubmapGraph, DisabledKindsTakeNoPart) {
  SubmapGraph graph = chain(drifting(kTruth, Noise()), Noise());
  add_loop(&graph, 0, kLast, relative(kTruth[0], kTruth.back()));
  graph.set_kind_enabled(ConstraintKind::kLoop, false);
  const OptimizeReport report = graph.optimize();
  EXPECT_EQ(report.kinds[static_cast<int>(ConstraintKind::kLoop)].num_constraints, 0);
  EXPECT_LT(report.cost_after, 1e-9);
}

TEST(SubmapGraph, RefusesWhatItCannotUse) {
  SubmapGraph graph;
  graph.add_submap(1, geometry::Pose::Identity());
  EXPECT_THROW(graph.add_submap(1, geometry::Pose::Identity()), std::invalid_argument);
  EXPECT_THROW(add_loop(&graph, 1, 2, Pose4::Zero()), std::invalid_argument);
  EXPECT_THROW(add_loop(&graph, 1, 1, Pose4::Zero()), std::invalid_argument);
  EXPECT_THROW(graph.add_position(9, {0, 0, 0}, {0, 0, 0}, Eigen::Matrix3d::Identity()), std::invalid_argument);
  EXPECT_THROW(graph.add_height(1, {0, 0, 0}, std::nan(""), 1.0), std::invalid_argument);
  SubmapGraphConfig config;
  config.max_submaps = 1;
  SubmapGraph small(config);
  small.add_submap(0, geometry::Pose::Identity());
  EXPECT_THROW(small.add_submap(1, geometry::Pose::Identity()), std::length_error);
}

TEST(SubmapGraph, EmptyAndSingleGraphsSolve) {
  SubmapGraph graph;
  EXPECT_TRUE(graph.optimize().is_converged);
  graph.add_submap(4, to_pose(Pose4(1, 2, 3, 0.4)));
  graph.optimize();
  EXPECT_TRUE(graph.poses().at(4).isApprox(to_pose(Pose4(1, 2, 3, 0.4)), 1e-12));
}
