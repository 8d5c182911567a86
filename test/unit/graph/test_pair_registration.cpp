// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "graph/pair_registration.hpp"
#include "grid_field.hpp"

using namespace voxnav::graph;         // NOLINT: test
using namespace voxnav::test_support;  // NOLINT: test

namespace {

const std::vector<double> kKernels{1.6, 0.8, 0.4};

struct Pair {
  SurfaceSample a;
  SurfaceSample b;
  Pose4 truth;
};

Pair make_pair_of(const ForestWorld& world, const Pose4& T_W_A, const Pose4& T_W_B) {
  View view_b;
  view_b.seed = 2;
  return {draw_sample(make_submap(world, to_pose(T_W_A), View()), 1200, 3.2),
          draw_sample(make_submap(world, to_pose(T_W_B), view_b), 1200, 3.2), relative(T_W_A, T_W_B)};
}

const Pair& forest_pair() {
  static const Pair pair = make_pair_of(make_forest(40, 400, 3), Pose4(0, 0, 2, 0.3), Pose4(4, -2, 2.5, 1.1));
  return pair;
}

constexpr double kQuarterVoxelM = 0.1;

ForestWorld meadow() {
  ForestWorld world;
  world.hill_m = 0.1;
  return world;
}

/// Sets the times of observation so that they rise with y, from 0 at -15 m to 1 at 15 m.
void see_from_left_to_right(SurfaceSample* sample) {
  const auto phase_at = [](double y) { return std::clamp(y / 30.0 + 0.5, 0.0, 1.0); };
  std::vector<SurfacePoint> points = sample->field->surface_points();
  for (SurfacePoint& point : points) point.phase = static_cast<float>(phase_at(point.position.y()));
  sample->phases = PhaseGrid(points);
  for (SamplePoint& point : sample->points) point.phase = phase_at(point.position_S.y());
}

}  // namespace

TEST(DrawSample, PrefixIsBalancedAndRepeatable) {
  const auto field = make_submap(make_forest(40, 400, 3), Pose::Identity(), View());
  const SurfaceSample sample = draw_sample(field, 400, 3.2);
  const SurfaceSample again = draw_sample(field, 400, 3.2);
  ASSERT_EQ(sample.points.size(), 400u);
  int upright = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    upright += sample.points[i].is_upright;
    EXPECT_EQ(sample.points[i].position_S, again.points[i].position_S);
  }
  EXPECT_EQ(upright, 100);
}

TEST(DrawSample, DropsPointsThatAreNotFinite) {
  std::vector<SurfacePoint> points(3, SurfacePoint{{0, 0, 0}, {0, 0, 1}, 1.0f});
  points[0].position.x() = std::nanf("");
  points[1].weight = 0.0f;
  const auto field = std::make_shared<GridField>(
      voxnav::geometry::Aabb{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, 0.4, [](const Vec3& p) { return p.z(); }, points);
  EXPECT_EQ(draw_sample(field, 10, 1.0).points.size(), 1u);
}

/// Compares twice the gradient of the model with differences of the cost.
void expect_numeric_gradient(const Pair& pair, const Pose4& T) {
  const PairOverlap overlap = find_overlap(pair.a, pair.b, T, 200);
  // A wide robust kernel makes the cost smooth over the step. Trilinear interpolation still has kinks between cells,
  // hence the tolerance.
  const PairModel model = evaluate_pair(pair.a, pair.b, overlap, T, 1.6);
  for (int k = 0; k < 4; ++k) {
    const double step = k == 3 ? 1e-5 : 1e-4;
    Pose4 plus = T;
    Pose4 minus = T;
    plus[k] += step;
    minus[k] -= step;
    const double slope = (evaluate_pair(pair.a, pair.b, overlap, plus, 1.6).cost_m2 -
                          evaluate_pair(pair.a, pair.b, overlap, minus, 1.6).cost_m2) /
                         (2.0 * step);
    EXPECT_NEAR(2.0 * model.gradient[k], slope, 0.02 * std::abs(slope) + 1e-3) << "parameter " << k;
  }
}

TEST(EvaluatePair, GradientEqualsNumericOne) {
  Pair pair = forest_pair();
  // On planes only the part of the gradient along the normal is used, which differs from the numeric gradient of the
  // interpolated distance; so no point is planar here.
  for (SurfaceSample* sample : {&pair.a, &pair.b}) {
    for (SamplePoint& point : sample->points) point.is_planar = false;
  }
  const Pose4 T = pair.truth + Pose4(0.2, -0.15, 0.1, 0.02);
  expect_numeric_gradient(pair, T);
  // The gradients are equal as well if the submaps drifted while they were made.
  for (SurfaceSample* sample : {&pair.a, &pair.b}) see_from_left_to_right(sample);
  pair.a.sway = {Vec3(0.3, -0.2, 0.05), Vec3(-0.2, 0.25, 0.0)};
  pair.b.sway = {Vec3(-0.1, 0.3, 0.0), Vec3(0.2, 0.2, -0.05)};
  expect_numeric_gradient(pair, T);
}

/// Submap B was observed from one side to the other while it drifted along x, which looks like a rotation.
TEST(RefinePair, KnownDriftWithinASubmapIsNotTakenForARotation) {
  Pair pair = forest_pair();
  see_from_left_to_right(&pair.b);
  const Sway sway{Vec3(0.35, 0.1, 0.0), Vec3(-0.35, -0.1, 0.0)};
  for (SamplePoint& point : pair.b.points) point.position_S -= sway.at(point.phase);
  PairOverlap overlap = find_overlap(pair.a, pair.b, pair.truth, 400);
  overlap.of_a.clear();  // the field of B was made without drift
  const auto registered = [&] { return refine_pair(pair.a, pair.b, overlap, pair.truth, {0.8, 0.4}, 0.03).T_A_B; };
  EXPECT_GT(std::abs(registered()[3] - pair.truth[3]), 0.008);
  pair.b.sway = sway;
  Pose4 expected = pair.truth;  // the pose of B at the mean time at which it saw the shared surfaces, set below
  expected.head<3>() += to_pose(Pose4(0, 0, 0, pair.truth[3])) * sway.at(overlap.phase_b);
  const Pose4 error = registered() - expected;
  EXPECT_LT(error.head<3>().norm(), 0.04) << error.transpose();
  EXPECT_LT(std::abs(error[3]), 0.003);
}

TEST(EvaluatePair, TheEndOfAPlaneHoldsNothingAlongThePlane) {
  // A saw the ground up to x = 0 and B beyond it, so that the point of A nearest to a point of B lies beside it as
  // well.
  const voxnav::geometry::Aabb box{Vec3(-8, -8, -2), Vec3(8, 8, 2)};
  const auto ground = [](double first, double last) {
    std::vector<SurfacePoint> points;
    for (int i = 0; first + 0.4 * i < last; ++i) {
      for (int j = -10; j < 10; ++j)
        points.push_back({Vec3(first + 0.4 * i, 0.4 * j, 0.05).cast<float>(), voxnav::geometry::Vec3f::UnitZ(), 0.8f});
    }
    return points;
  };
  const auto to_end = [](const Vec3& p) { return std::hypot(std::max(p.x(), 0.0), p.z()); };
  const auto flat = [](const Vec3& p) { return std::abs(p.z()); };
  const SurfaceSample a = draw_sample(std::make_shared<GridField>(box, 0.4, to_end, ground(-4.0, 0.0)), 400, 1.6);
  const SurfaceSample b = draw_sample(std::make_shared<GridField>(box, 0.4, flat, ground(0.05, 0.4)), 400, 1.6);
  const PairOverlap overlap = find_overlap(a, b, Pose4::Zero(), 200);
  const PairModel model = evaluate_pair(a, b, overlap, Pose4::Zero(), 0.8);
  EXPECT_EQ(model.hessian(0, 0), 0.0);
  EXPECT_EQ(model.gradient[0], 0.0);
  EXPECT_GT(model.hessian(2, 2), 0.0);
}

TEST(EvaluatePair, LosingOverlapCostsAsMuchAsAnOutlier) {
  const Pair& pair = forest_pair();
  const PairOverlap overlap = find_overlap(pair.a, pair.b, pair.truth, 200);
  const double aligned = evaluate_pair(pair.a, pair.b, overlap, pair.truth, 0.4).cost_m2;
  const PairModel apart = evaluate_pair(pair.a, pair.b, overlap, pair.truth + Pose4(500, 0, 0, 0), 0.4);
  EXPECT_LT(aligned, 0.1 * 0.4 * 0.4);
  EXPECT_DOUBLE_EQ(apart.cost_m2, 0.4 * 0.4);
  EXPECT_EQ(apart.matched_ratio, 0.0);
}

TEST(RefinePair, RecoversOffsetsInForest) {
  const Pair& pair = forest_pair();
  for (const Pose4& offset : {Pose4(0.6, -0.4, 0.3, 0.05), Pose4(-0.8, 0.5, -0.4, -0.06), Pose4(0.3, 0.9, 0.2, 0.03)}) {
    const Pose4 start = pair.truth + offset;
    const PairOverlap overlap = find_overlap(pair.a, pair.b, start, 200);
    const Pose4 error = refine_pair(pair.a, pair.b, overlap, start, kKernels, 0.03).T_A_B - pair.truth;
    EXPECT_LT(error.head<3>().norm(), kQuarterVoxelM) << error.transpose();
    EXPECT_LT(std::abs(error[3]), 0.01);
  }
}

TEST(SearchPair, FindsThreeMetresAndTenDegrees) {
  const Pair& pair = forest_pair();
  const PairSearch search{3.2, 0.2, 0.8, 100, 0.9};
  for (const Pose4& offset : {Pose4(2.1, -2.0, 0.3, 0.17), Pose4(-2.8, 0.5, -0.2, -0.17), Pose4(0.4, 2.9, 0.1, 0.12)}) {
    const std::optional<Pose4> found = search_pair(pair.a, pair.b, pair.truth + offset, search);
    ASSERT_TRUE(found.has_value()) << offset.transpose();
    const PairOverlap overlap = find_overlap(pair.a, pair.b, *found, 200);
    const Pose4 error = refine_pair(pair.a, pair.b, overlap, *found, kKernels, 0.03).T_A_B - pair.truth;
    EXPECT_LT(error.head<3>().norm(), kQuarterVoxelM) << error.transpose();
    EXPECT_LT(std::abs(error[3]), 0.01);
  }
}

TEST(SearchPair, ReturnsNothingIfNoAlignmentStandsOut) {
  const Pair pair = make_pair_of(meadow(), Pose4(0, 0, 2, 0), Pose4(5, 0, 2, 0));
  EXPECT_FALSE(search_pair(pair.a, pair.b, pair.truth, {3.2, 0.2, 0.8, 100, 0.9}).has_value());
}

TEST(ToFactor, GroundAloneHoldsHeightAndLeavesTheRestFree) {
  const Pair pair = make_pair_of(meadow(), Pose4(0, 0, 2, 0), Pose4(5, 3, 2, 0.7));
  const Pose4 start = pair.truth + Pose4(0.5, -0.4, 0.3, 0.05);
  const PairOverlap overlap = find_overlap(pair.a, pair.b, start, 200);
  const PairModel model = refine_pair(pair.a, pair.b, overlap, start, kKernels, 0.03);
  EXPECT_NEAR(model.T_A_B[2], pair.truth[2], 0.05);
  EXPECT_NEAR((model.T_A_B - start).head<2>().norm(), 0.0, 0.05);
  EXPECT_NEAR(model.T_A_B[3], start[3], 0.005);
  const RelativePoseFactor factor = to_factor(model, 1000.0, 0.03, 0.4);
  const Matrix4 information = factor.whitening.transpose() * factor.whitening;
  EXPECT_GT(information(2, 2), 500.0);
  EXPECT_LT(information(0, 0), 20.0);
  EXPECT_LT(information(1, 1), 20.0);
  EXPECT_LT(information(3, 3), 20.0);
}

TEST(ToFactor, TrunksHoldEverything) {
  const Pair& pair = forest_pair();
  const PairOverlap overlap = find_overlap(pair.a, pair.b, pair.truth, 200);
  const PairModel model = refine_pair(pair.a, pair.b, overlap, pair.truth, kKernels, 0.03);
  const RelativePoseFactor factor = to_factor(model, 1000.0, 0.03, 0.4);
  const Matrix4 information = factor.whitening.transpose() * factor.whitening;
  for (int k = 0; k < 4; ++k) EXPECT_GT(information(k, k), 40.0) << k;
}
