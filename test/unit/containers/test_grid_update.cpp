// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "voxnav/containers/state_grid.hpp"

using namespace voxnav;  // NOLINT: test
using containers::GridUpdate;
using containers::StateGrid;
using containers::VoxelState;

namespace {

StateGrid random_grid(unsigned seed) {
  StateGrid grid(0.4);
  std::mt19937 rng(seed);
  std::uniform_int_distribution<int> coordinate(-40, 40);
  for (int i = 0; i < 5000; ++i) {
    grid.set({coordinate(rng), coordinate(rng), coordinate(rng)}, static_cast<VoxelState>(rng() % 3));
  }
  return grid;
}

void expect_equal(const StateGrid& a, const StateGrid& b) {
  for (int x = -40; x <= 40; ++x) {
    for (int y = -40; y <= 40; ++y) {
      for (int z = -40; z <= 40; ++z) ASSERT_EQ(a.state(geometry::Index3{x, y, z}), b.state(geometry::Index3{x, y, z}));
    }
  }
}

}  // namespace

TEST(GridUpdate, SnapshotReplacesEverything) {
  const StateGrid source = random_grid(1);
  StateGrid copy = random_grid(2);
  containers::apply(containers::snapshot_of(source), &copy);
  expect_equal(source, copy);
}

TEST(GridUpdate, ChangesCarryNewAndRemovedBlocks) {
  StateGrid source = random_grid(1);
  StateGrid copy = source;
  source.erase_block({0, 0, 0});
  source.set({20, -20, 3}, VoxelState::kOccupied);
  containers::apply(containers::changes_of(source, {{0, 0, 0}, {1, -2, 0}}), &copy);
  expect_equal(source, copy);
}

TEST(GridUpdate, BrokenUpdatesAreRefusedAndChangeNothing) {
  const StateGrid source = random_grid(1);
  const GridUpdate good = containers::snapshot_of(source);
  StateGrid grid = source;
  GridUpdate short_states = good;
  short_states.states.pop_back();
  EXPECT_THROW(containers::apply(short_states, &grid), std::invalid_argument);
  GridUpdate not_threes = good;
  not_threes.removed_block_indices.push_back(1);
  EXPECT_THROW(containers::apply(not_threes, &grid), std::invalid_argument);
  GridUpdate bad_state = good;
  bad_state.states[7] |= 0x0Cu;
  EXPECT_THROW(containers::apply(bad_state, &grid), std::invalid_argument);
  GridUpdate far = good;
  far.block_indices[0] = 1 << 30;
  EXPECT_THROW(containers::apply(far, &grid), std::invalid_argument);
  expect_equal(source, grid);
}
