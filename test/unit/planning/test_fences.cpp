// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "box_grid.hpp"
#include "voxnav/planning/corridor.hpp"
#include "voxnav/planning/fences.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Vec3;
using planning::FenceKind;
using planning::Fences;
using planning::Prism;

namespace {

/// An L of 10 x 10 m whose inner corner is at (5, 5), from 0 to 10 m.
Prism l_shape() { return {{{0, 0}, {10, 0}, {10, 5}, {5, 5}, {5, 10}, {0, 10}}, 0.0, 10.0}; }

Prism box(double x0, double y0, double x1, double y1) { return {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, 2.0, 4.0}; }

/// A free grid with fences.
class FencedView : public planning::StateGridView {
 public:
  explicit FencedView(std::shared_ptr<const Fences> fences)
      : StateGridView(test::box_grid({-20, -20, -20}, {20, 20, 20})), fences_(std::move(fences)) {}
  std::shared_ptr<const Fences> fences() const override { return fences_; }

 private:
  std::shared_ptr<const Fences> fences_;
};

}  // namespace

TEST(Fences, ProblemsOfPrismsAreNamed) {
  EXPECT_EQ(planning::problem_of(l_shape()), "");
  EXPECT_NE(planning::problem_of({{{0, 0}, {1, 0}}, 0, 1}).find("3 corners"), std::string::npos);
  EXPECT_NE(planning::problem_of({{{0, 0}, {1, 0}, {0, 1}}, 1, 1}).find("min_z"), std::string::npos);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(planning::problem_of({{{0, 0}, {1, nan}, {0, 1}}, 0, 1}).find("finite"), std::string::npos);
  const Prism bow_tie{{{0, 0}, {2, 2}, {2, 0}, {0, 2}}, 0, 1};
  EXPECT_NE(planning::problem_of(bow_tie).find("cross"), std::string::npos);
  const Prism repeated{{{0, 0}, {1, 0}, {1, 0}, {0, 1}}, 0, 1};
  EXPECT_NE(planning::problem_of(repeated).find("repeated"), std::string::npos);
  const Prism spike{{{0, 0}, {4, 0}, {2, 0}, {2, 2}}, 0, 1};
  EXPECT_NE(planning::problem_of(spike), "");
  EXPECT_THROW(Fences(bow_tie, {}), std::invalid_argument);
  EXPECT_THROW(Fences(std::nullopt, {box(0, 0, 1, 1), bow_tie}), std::invalid_argument);
}

TEST(Fences, TheAreaBoundsTheCentre) {
  const Fences fences(l_shape(), {});
  EXPECT_FALSE(fences.contact({1, 1, 1}, 3.0));
  EXPECT_EQ(fences.contact({7, 7, 1}, 0.0)->kind, FenceKind::kArea);
  EXPECT_EQ(fences.contact({1, 1, 10.1}, 0.0)->kind, FenceKind::kArea);
  // From one arm of the L to the other straight on: over the inner corner.
  const auto touch = fences.first_touch({9, 4, 1}, {4, 9, 1}, 0.0);
  ASSERT_TRUE(touch);
  EXPECT_NEAR(touch->t, 0.2, 1e-12);
  EXPECT_FALSE(fences.first_touch({9, 4, 1}, {4, 4, 9}, 0.0));
  EXPECT_NEAR(fences.first_touch({1, 1, 8}, {1, 1, 12}, 0.0)->t, 0.5, 1e-12);
  EXPECT_EQ(fences.first_touch({1, 1, 11}, {1, 1, 5}, 0.0)->t, 0.0);
}

TEST(Fences, ABallMayNotTouchAZone) {
  const Fences fences(std::nullopt, {box(10, 10, 11, 11), box(4, -1, 6, 1)});
  EXPECT_EQ(fences.contact({5, 0, 3}, 0.0)->zone, 1u);
  EXPECT_FALSE(fences.contact({5, 0, 5}, 0.9));
  EXPECT_TRUE(fences.contact({5, 0, 5}, 1.0));
  EXPECT_NEAR(fences.first_touch({0, 0, 3}, {8, 0, 3}, 0.5)->t * 8.0, 3.5, 2e-3);
  // Beside a corner the ball passes at its radius.
  EXPECT_FALSE(fences.first_touch({0, 1.75, 3}, {8, 1.75, 3}, 0.7));
  EXPECT_TRUE(fences.first_touch({0, 1.65, 3}, {8, 1.65, 3}, 0.7));
  EXPECT_FALSE(fences.first_touch({0, 0, 3}, {0, 0, 3}, 0.5));
}

TEST(Fences, CorridorsEndAtFences) {
  const FencedView view(std::make_shared<Fences>(l_shape(), std::vector<Prism>{box(2, 7, 3, 8)}));
  const std::vector<Vec3> out = {{9, 2, 3}, {9, 4, 3}, {4, 9, 3}};
  const auto corridor = planning::check_corridor(view, out, 0.5);
  ASSERT_FALSE(corridor.is_safe);
  EXPECT_EQ(corridor.fence->kind, FenceKind::kArea);
  EXPECT_NEAR(corridor.first_unsafe_m, 2.0 + std::sqrt(2.0), 1e-9);
  EXPECT_STREQ(what_is_unsafe(corridor), "outside the safety area");
  // The border of the area is for the centre, a zone for the whole ball.
  EXPECT_TRUE(planning::check_corridor(view, {{0.1, 0.1, 3}, {9, 0.1, 3}}, 0.5).is_safe);
  const std::vector<Vec3> along = {{1.4, 1, 3}, {1.4, 9, 3}};
  EXPECT_TRUE(planning::check_corridor(view, along, 0.5).is_safe);
  const auto near = planning::check_corridor(view, along, 0.7);
  EXPECT_EQ(near.fence->kind, FenceKind::kZone);
  // What is only not to be occupied may leave the area, but not enter a zone.
  EXPECT_TRUE(planning::check_corridor(view, out, 0.5, planning::CorridorRule::kNotOccupied).is_safe);
  EXPECT_FALSE(planning::check_corridor(view, along, 0.7, planning::CorridorRule::kNotOccupied).is_safe);
}

TEST(Fences, TheNearerOfAVoxelAndAFenceIsReported) {
  auto grid = test::box_grid({-20, -20, -20}, {20, 20, 20});
  grid->set({8, 2, 3}, containers::VoxelState::kOccupied);
  class View : public planning::StateGridView {
   public:
    using StateGridView::StateGridView;
    std::shared_ptr<const Fences> fences() const override {
      return std::make_shared<Fences>(l_shape(), std::vector<Prism>{});
    }
  };
  const View view(grid);
  const auto tree = planning::check_corridor(view, {{1, 2.5, 3.5}, {12, 2.5, 3.5}}, 0.5);
  EXPECT_FALSE(tree.fence);
  EXPECT_NEAR(tree.first_unsafe_m, 6.5, 1e-6);
  const auto border = planning::check_corridor(view, {{9.5, 2.5, 3.5}, {12, 2.5, 3.5}, {12, 30, 3.5}}, 0.1);
  EXPECT_TRUE(border.fence);
  EXPECT_NEAR(border.first_unsafe_m, 0.5, 1e-9);
}
