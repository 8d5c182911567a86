// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/grid_conversions.hpp"
#include "voxnav_ros/messages.hpp"

using namespace voxnav_ros;  // NOLINT: test
namespace containers = voxnav::containers;

namespace {

containers::GridUpdate example() {
  containers::GridUpdate update;
  update.is_snapshot = true;
  update.block_indices = {1, -2, 3};
  update.removed_block_indices = {4, 5, -6, 7, 8, 9};
  update.states = {1, 2, 3, 4};
  return update;
}

}  // namespace

TEST(GridConversions, AnUpdateComesBackAsItWas) {
  const containers::GridUpdate update = example();
  const containers::GridUpdate back = from_msg(to_msg(update, {"map", 5, 6, 0.4}));
  EXPECT_EQ(back.is_snapshot, update.is_snapshot);
  EXPECT_EQ(back.block_indices, update.block_indices);
  EXPECT_EQ(back.removed_block_indices, update.removed_block_indices);
  EXPECT_EQ(back.states, update.states);
}

TEST(GridConversions, TheMessageHoldsFrameStampAndSequence) {
  const msg::GridUpdate msg = to_msg(example(), {"uav1/voxnav_map", 1500000001LL, 42, 0.25});
  EXPECT_EQ(msg.header.frame_id, "uav1/voxnav_map");
  EXPECT_EQ(to_ns(msg.header.stamp), 1500000001LL);
  EXPECT_EQ(msg.sequence, 42u);
  EXPECT_DOUBLE_EQ(msg.resolution_m, 0.25);
  EXPECT_TRUE(msg.is_snapshot);
}

TEST(GridConversions, ListsOfWrongLengthAreRefusedByTheGrid) {
  containers::GridUpdate update = example();
  update.block_indices.push_back(0);
  const containers::GridUpdate back = from_msg(to_msg(update, {"map", 0, 0, 0.4}));
  containers::StateGrid grid(0.4);
  EXPECT_ANY_THROW(containers::apply(back, &grid));
}
