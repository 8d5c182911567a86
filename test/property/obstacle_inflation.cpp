// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "kernels/processor.hpp"
#include "voxnav/submap/obstacle_map.hpp"
#include "voxnav/submap/submap_collection.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Pose;
using geometry::Vec3;
using submap::ObstacleMap;
using submap::SubmapCollection;

namespace {

constexpr double kVoxel = 0.4;

submap::SubmapEntry entry_of(std::uint32_t id, const Pose& T_W_S, double density = 0.002) {
  submap::SubmapEntry entry;
  entry.id = id;
  entry.end_ns = id;
  entry.T_W_S = T_W_S;
  entry.submap = submap::Submap::from_content(test::random_content(id, 36, density, 0.2, kVoxel),
                                              geometry::from_position_yaw({0.1, 0.2, 0.3}, 0.2), {});
  return entry;
}

void expect_equal(const containers::StateGrid& a, const containers::StateGrid& b) {
  ASSERT_EQ(a.sorted_block_indices().size(), b.sorted_block_indices().size());
  for (const auto& index : a.sorted_block_indices()) {
    const auto* other = b.find_block(index);
    ASSERT_NE(other, nullptr);
    ASSERT_EQ(a.find_block(index)->words, other->words);
  }
}

}  // namespace

TEST(ObstacleInflation, EqualsBruteForce) {
  for (const double safety_m : {0.0, 0.5, 1.5}) {
    SubmapCollection collection({});
    collection.add(entry_of(1, Pose::Identity()));
    collection.add(entry_of(2, geometry::from_position_yaw({3, 2, -1}, 0.5)));
    const containers::StateGrid grid = collection.obstacles(safety_m);
    const auto points = collection.occupied_points();
    const double reach = safety_m + 0.5 * std::sqrt(3.0) * kVoxel;
    std::mt19937 rng(8);
    int num_occupied = 0;
    for (int i = 0; i < 4000; ++i) {
      const auto voxel = geometry::index_of(test::random_in(&rng, {-12, -8, -12}, {12, 18, 12}), kVoxel);
      const Vec3 center = geometry::center_of(voxel, kVoxel);
      double nearest = 1e9;
      for (const auto& p : points) nearest = std::min(nearest, (p.cast<double>() - center).norm());
      if (std::abs(nearest - reach) < 1e-5) continue;  // the points are rounded to float
      const VoxelState state = grid.state(voxel);
      ASSERT_EQ(state == VoxelState::kOccupied, nearest < reach) << nearest;
      ASSERT_EQ(state == VoxelState::kFree, nearest >= reach && collection.state(center) == VoxelState::kFree);
      num_occupied += state == VoxelState::kOccupied;
    }
    EXPECT_GT(num_occupied, 0);
  }
}

TEST(ObstacleInflation, EveryInstructionSetGivesTheSame) {
  for (const double safety_m : {0.3, 1.5, 2.4}) {
    const auto inflate = [&](bool wide) {
      kernels::use_wide(wide);
      SubmapCollection collection({});
      collection.add(entry_of(1, Pose::Identity(), 0.02));
      collection.add(entry_of(2, geometry::from_position_yaw({3, 2, -1}, 0.5), 0.02));
      return collection.obstacles(safety_m);
    };
    const containers::StateGrid plain = inflate(false);
    expect_equal(inflate(true), plain);
  }
}

TEST(ObstacleInflation, ChangesAddUpToTheWhole) {
  SubmapCollection collection({});
  ObstacleMap incremental(kVoxel, 1.0);
  containers::StateGrid received(kVoxel);
  std::mt19937 rng(3);
  for (std::uint32_t step = 1; step <= 8; ++step) {
    const Pose pose = geometry::from_position_yaw(test::random_in(&rng, {-8, -8, -1}, {8, 8, 1}), 0.1 * step);
    if (step <= 4) {
      collection.add(entry_of(step, pose));
    } else if (step == 8) {
      collection.remove(2);
    } else {
      collection.set_pose(step - 4, pose);
    }
    incremental.mark_changed(collection.update());
    while (incremental.update(collection.evidence(), 7) > 0) {
    }
    containers::apply(incremental.take_changes(), &received);
    expect_equal(incremental.grid(), collection.obstacles(1.0));
    expect_equal(received, incremental.grid());
  }
  EXPECT_TRUE(incremental.take_changes().block_indices.empty());
}
