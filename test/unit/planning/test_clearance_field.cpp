// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "box_grid.hpp"
#include "voxnav/planning/clearance_field.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;
using planning::ClearanceField;
using planning::ClearanceFieldConfig;
using planning::StateGridView;

namespace {

ClearanceFieldConfig config_of(double safety_distance_m, double radius_m) {
  ClearanceFieldConfig config;
  config.safety_distance_m = safety_distance_m;
  config.radius_m = radius_m;
  return config;
}

/// A wall at x = 20 in a free box of 48 x 32 x 16 voxels of 1 m.
std::shared_ptr<containers::StateGrid> divided_box() {
  auto grid = test::box_grid({0, 0, 0}, {47, 31, 15});
  test::fill(grid.get(), {20, 0, 0}, {20, 31, 15}, VoxelState::kOccupied);
  return grid;
}

}  // namespace

TEST(ClearanceField, AWallDividesSpaceUntilItHasADoor) {
  const auto grid = divided_box();
  ClearanceField field(config_of(1.0, 3.0));
  field.update(StateGridView(grid));
  const Vec3 left(5.5, 5.5, 5.5), right(40.5, 20.5, 5.5);
  EXPECT_NE(field.component(left), 0u);
  EXPECT_NE(field.component(right), 0u);
  EXPECT_NE(field.component(left), field.component(right));
  EXPECT_EQ(field.component({20.5, 5.5, 5.5}), 0u) << "the wall itself";
  EXPECT_EQ(field.component({19.5, 5.5, 5.5}), 0u) << "half a metre from the wall";
  EXPECT_EQ(field.component({18.5, 5.5, 5.5}), field.component(left));
  test::fill(grid.get(), {20, 10, 6}, {20, 12, 8}, VoxelState::kFree);
  const auto update = field.update(StateGridView(grid));
  EXPECT_EQ(update.changed_blocks, 1u);
  EXPECT_EQ(field.component(left), field.component(right));
}

TEST(ClearanceField, AnUpdateWithoutChangesRecomputesNothing) {
  const auto grid = divided_box();
  ClearanceField field(config_of(1.0, 3.0));
  const auto first = field.update(StateGridView(grid));
  EXPECT_EQ(first.changed_blocks, 6u);
  const auto second = field.update(StateGridView(grid));
  EXPECT_EQ(second.changed_blocks, 0u);
  EXPECT_EQ(second.recomputed_blocks, 0u);
}

TEST(ClearanceField, ListedBlocksAreEnough) {
  const auto grid = divided_box();
  ClearanceField field(config_of(1.0, 3.0));
  field.update(StateGridView(grid));
  grid->set({5, 5, 5}, VoxelState::kOccupied);
  field.update(StateGridView(grid), {geometry::block_of({5, 5, 5})});
  EXPECT_DOUBLE_EQ(field.clearance({7.5, 5.5, 5.5}), 1.5);
}

TEST(ClearanceField, AnotherResolutionStartsAnew) {
  ClearanceField field(config_of(0.5, 1.0));
  field.update(StateGridView(divided_box()));
  field.update(StateGridView(test::box_grid({0, 0, 0}, {15, 15, 15}, 0.5)));
  EXPECT_EQ(field.num_blocks(), 1u);
  EXPECT_EQ(field.resolution_m(), 0.5);
  EXPECT_EQ(field.clearance({5.0, 5.0, 5.0}), 1.0) << "nothing within the radius";
}

TEST(ClearanceField, BadInputIsRefusedOrAnswered) {
  EXPECT_THROW(ClearanceField(config_of(2.0, 1.0)), base::ConfigError);
  auto fine = std::make_shared<containers::StateGrid>(0.25);
  fine->set({0, 0, 0}, VoxelState::kFree);
  ClearanceField field(config_of(5.0, 20.0));
  EXPECT_THROW(field.update(StateGridView(fine)), std::invalid_argument) << "20 voxels are too many";
  EXPECT_NO_THROW(ClearanceField(config_of(1.0, 20.0)).update(StateGridView(fine)));
  ClearanceField empty(config_of(1.0, 2.0));
  EXPECT_EQ(empty.component({0.0, 0.0, 0.0}), 0u);
  EXPECT_EQ(empty.clearance({0.0, 0.0, 0.0}), 2.0);
  empty.update(StateGridView(divided_box()));
  EXPECT_EQ(empty.component(Vec3::Constant(1e300)), 0u);
  EXPECT_EQ(empty.component(Vec3::Constant(std::numeric_limits<double>::quiet_NaN())), 0u);
  EXPECT_TRUE(std::isnan(empty.clearance(Vec3::Constant(std::numeric_limits<double>::infinity()))));
}

TEST(ClearanceField, AMapBeyondTheMemoryLimitLeavesNothingFlyable) {
  ClearanceFieldConfig config = config_of(1.0, 2.0);
  config.max_memory_mib = 1.0;
  ClearanceField field(config);
  field.update(StateGridView(divided_box()));
  EXPECT_LT(field.memory_bytes(), 1u << 20);
  EXPECT_THROW(field.update(StateGridView(test::box_grid({0, 0, 0}, {79, 79, 79}))), std::length_error);
  EXPECT_EQ(field.num_blocks(), 0u);
  EXPECT_EQ(field.component({5.5, 5.5, 5.5}), 0u);
}
