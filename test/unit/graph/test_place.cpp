// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "graph/place.hpp"
#include "grid_field.hpp"

using namespace voxnav::graph;         // NOLINT: test
using namespace voxnav::test_support;  // NOLINT: test

namespace {

Place place_at(const ForestWorld& world, const Pose4& T_W_S, unsigned seed) {
  View view;
  view.range_m = 22.0;
  view.seed = seed;
  return describe_place(observe(world, to_pose(T_W_S), view));
}

}  // namespace

TEST(Place, LandmarksAreTheTrunks) {
  const ForestWorld world = make_forest(40, 250, 3);
  const Pose4 T_W_S(2.0, -3.0, 2.0, 0.7);
  const Place place = place_at(world, T_W_S, 1);
  int near = 0;
  for (const Vec3& landmark : place.landmarks_S) {
    const Vec3 p = to_pose(T_W_S) * landmark;
    for (const Trunk& t : world.trunks) {
      if (std::hypot(p.x() - t.x_m, p.y() - t.y_m) < 0.3) {
        ++near;
        break;
      }
    }
  }
  EXPECT_GT(place.landmarks_S.size(), 15u);
  EXPECT_GT(near, 0.9 * static_cast<double>(place.landmarks_S.size()));
}

TEST(Place, IsRecognisedFromAnotherHeadingAndOtherPositions) {
  int found = 0;
  constexpr int kTrials = 20;
  for (unsigned trial = 0; trial < kTrials; ++trial) {
    const ForestWorld world = make_forest(60, 250, 100 + trial);
    std::mt19937 rng(trial);
    std::uniform_real_distribution<double> offset(-4.0, 4.0);
    std::uniform_real_distribution<double> heading(-3.1, 3.1);
    const double dx = offset(rng);
    const double dy = offset(rng);
    const Pose4 T_W_A(0.0, 0.0, 2.0, 0.3);
    const Pose4 T_W_B(dx, dy, 2.5, heading(rng));
    const auto match = match_places(place_at(world, T_W_A, 1), place_at(world, T_W_B, 2));
    if (!match) continue;
    ++found;
    const Pose4 error = match->T_A_B - relative(T_W_A, T_W_B);
    EXPECT_LT(error.head<3>().norm(), 0.5) << "trial " << trial;
    EXPECT_LT(std::abs(voxnav::geometry::wrap_angle(error[3])), 0.03) << "trial " << trial;
  }
  EXPECT_GE(found, 18);
}

TEST(Place, OtherPlacesDoNotMatch) {
  int found = 0;
  for (unsigned trial = 0; trial < 40; ++trial) {
    const Place a = place_at(make_forest(40, 250, 200 + trial), Pose4(0, 0, 2, 0), 1);
    const Place b = place_at(make_forest(40, 250, 300 + trial), Pose4(0, 0, 2, 1), 2);
    found += match_places(a, b).has_value();
  }
  EXPECT_LE(found, 2);
}

TEST(Place, TheIndexNamesTheSamePlaceFirst) {
  const ForestWorld world = make_forest(200, 250, 5);
  PlaceIndex index;
  for (int id = 0; id < 12; ++id) {
    const int column = id % 4, row = id / 4;
    index.add(id, place_at(world, Pose4(28.0 * column - 42.0, 28.0 * row - 28.0, 2.0, 0.5 * id), 1));
  }
  for (int id = 0; id < 12; ++id) {
    const int column = id % 4, row = id / 4;
    const Pose4 again(28.0 * column - 42.0 + 2.0, 28.0 * row - 28.0 + 1.0, 2.0, 3.0 - 0.5 * id);
    const std::vector<int> similar = index.similar(100, place_at(world, again, 2), 3);
    ASSERT_FALSE(similar.empty());
    EXPECT_EQ(similar[0], id);
  }
}

TEST(Place, BareGroundHasNoLandmarks) {
  const Place place = place_at(ForestWorld(), Pose4(0, 0, 2, 0), 1);
  EXPECT_TRUE(place.landmarks_S.empty());
  EXPECT_FALSE(match_places(place, place));
}
