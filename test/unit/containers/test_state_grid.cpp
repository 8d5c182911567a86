// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "voxnav/containers/state_grid.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;

TEST(StateGrid, EqualsAMapAfterRandomWrites) {
  containers::StateGrid grid(0.4);
  std::map<geometry::Index3, VoxelState> oracle;
  std::mt19937 rng(3);
  std::uniform_int_distribution<int> coordinate(-40, 40);
  for (int i = 0; i < 20000; ++i) {
    const geometry::Index3 voxel{coordinate(rng), coordinate(rng), coordinate(rng)};
    const VoxelState state = static_cast<VoxelState>(rng() % 3);
    grid.set(voxel, state);
    oracle[voxel] = state;
  }
  for (int x = -40; x <= 40; ++x) {
    for (int y = -40; y <= 40; ++y) {
      for (int z = -40; z <= 40; ++z) {
        const auto it = oracle.find({x, y, z});
        ASSERT_EQ(grid.state(geometry::Index3{x, y, z}), it == oracle.end() ? VoxelState::kUnknown : it->second);
      }
    }
  }
}

TEST(StateGrid, NotFiniteAndFarPointsAreUnknown) {
  containers::StateGrid grid(0.4);
  grid.set({0, 0, 0}, VoxelState::kFree);
  EXPECT_EQ(grid.state(geometry::Vec3(0.1, 0.1, 0.1)), VoxelState::kFree);
  EXPECT_EQ(grid.state(geometry::Vec3(std::nan(""), 0, 0)), VoxelState::kUnknown);
  EXPECT_EQ(grid.state(geometry::Vec3(1e30, 0, 0)), VoxelState::kUnknown);
}

TEST(StateGrid, AllUnknownBlocksAreDropped) {
  containers::StateGrid grid(0.4);
  grid.set({1, 1, 1}, VoxelState::kOccupied);
  grid.replace_block({0, 0, 0}, containers::StateBlock{});
  EXPECT_TRUE(grid.blocks().empty());
  EXPECT_THROW(containers::StateGrid(0.0), std::invalid_argument);
}
