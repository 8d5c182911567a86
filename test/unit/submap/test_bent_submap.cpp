// SPDX-License-Identifier: BSD-3-Clause
// Submaps whose pose drifted while they were made, so that content observed early or late is moved by their bend.
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "voxnav/submap/submap_collection.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Bend;
using geometry::Pose;
using geometry::Vec3;
using submap::SubmapCollection;
using submap::SubmapEntry;

namespace {

constexpr double kVoxel = 0.4;
const Pose kT_S_G = geometry::from_position_yaw({0.13, -0.3, 0.1}, 0.4);
const Pose kT_W_S = geometry::from_position_yaw({12.0, -3.0, 1.0}, -0.9);
const Bend kBend{geometry::from_position_yaw({-0.5, 0.2, 0.05}, 0.02),
                 geometry::from_position_yaw({0.4, 0.3, 0.0}, -0.03)};

/// Returns ground with posts and free space above, whose times of observation rise along x.
occupancy::MapContent passage() {
  test::ContentBuilder builder(kVoxel);
  for (int x = -40; x < 40; ++x) {
    for (int y = -12; y < 12; ++y) {
      for (int z = 1; z < 20; ++z) builder.set_free({x, y, z});
      builder.set_occupied({x, y, 0}, Vec3(0.2, -0.1, 0.3));
    }
  }
  for (int x = -35; x < 40; x += 10) {
    for (int z = 1; z < 8; ++z) builder.set_occupied({x, 3, z}, Vec3(-0.3, 0.1, 0.0));
  }
  occupancy::MapContent content = builder.build();
  for (occupancy::ContentBlock& block : content.blocks) {
    for (occupancy::OccupiedVoxel& leaf : block.occupied) {
      const int x = geometry::voxel_at(block.index, leaf.offset).x;
      leaf.observed_time = static_cast<std::uint8_t>((x + 40) * 255 / 80);
    }
  }
  return content;
}

SubmapEntry entry_of(std::uint32_t id, const Bend& bend) {
  SubmapEntry entry;
  entry.id = id;
  entry.end_ns = id;
  entry.T_W_S = kT_W_S;
  entry.bend = bend;
  entry.submap = submap::Submap::from_content(passage(), kT_S_G, {});
  return entry;
}

/// Returns a map with submap 2. Submap 1 lies far away; as it exists, what submap 2 only remembers does not count.
SubmapCollection map_of(const Bend& bend) {
  SubmapCollection out({});
  SubmapEntry before = entry_of(1, {});
  before.T_W_S.translation() += Vec3(500.0, 0.0, 0.0);
  out.add(std::move(before));
  out.add(entry_of(2, bend));
  return out;
}

std::vector<Vec3> points_of(SubmapCollection* map) {
  std::vector<Vec3> out;
  for (const auto& p : map->occupied_points()) {
    if (p.x() < 250.f) out.emplace_back(p.cast<double>());
  }
  return out;
}

double distance_to(const std::vector<Vec3>& points, const Vec3& p) {
  double nearest = 1e9;
  for (const Vec3& q : points) nearest = std::min(nearest, (q - p).norm());
  return nearest;
}

/// Returns the surface points in W that follow if each one is moved by the bend at its own time.
std::vector<Vec3> bent_one_by_one(const Bend& bend) {
  std::vector<Vec3> out;
  for (const occupancy::ContentBlock& block : passage().blocks) {
    for (const occupancy::OccupiedVoxel& leaf : block.occupied) {
      const Vec3 p_G = occupancy::surface_point(block.index, leaf, kVoxel).cast<double>();
      out.push_back(kT_W_S * bend.at(leaf.observed_time / 255.0) * kT_S_G * p_G);
    }
  }
  return out;
}

}  // namespace

TEST(BentSubmap, EveryPointIsMovedByTheBendAtItsTime) {
  SubmapCollection map = map_of(kBend);
  const std::vector<Vec3> points = points_of(&map);
  const std::vector<Vec3> expected = bent_one_by_one(kBend);
  ASSERT_EQ(points.size(), expected.size());
  for (const Vec3& p : expected) EXPECT_LT(distance_to(points, p), 0.003) << p.transpose();
}

TEST(BentSubmap, FreeSpaceAbovePostsAndGroundMovesWithThem) {
  SubmapCollection map = map_of(kBend);
  for (const occupancy::ContentBlock& block : passage().blocks) {
    for (const occupancy::OccupiedVoxel& leaf : block.occupied) {
      const geometry::Index3 voxel = geometry::voxel_at(block.index, leaf.offset);
      if (voxel.z != 0 || voxel.x < -38 || voxel.x > 37 || std::abs(voxel.y) > 9) continue;
      const Vec3 above = geometry::center_of(voxel + geometry::Index3{0, 0, 10}, kVoxel);
      EXPECT_EQ(map.state(kT_W_S * kBend.at(leaf.observed_time / 255.0) * kT_S_G * above), VoxelState::kFree);
    }
  }
}

/// A later submap with the same bend sees the same surfaces at the same places and removes none of them.
TEST(BentSubmap, ALaterSubmapWithTheSameBendRemovesNothing) {
  SubmapCollection map = map_of(kBend);
  map.add(entry_of(3, kBend));
  const std::vector<Vec3> points = points_of(&map);
  for (const Vec3& p : bent_one_by_one(kBend)) EXPECT_LT(distance_to(points, p), 0.003);
  EXPECT_TRUE(map.changes(1).empty());
}

TEST(BentSubmap, ABendThatIsSetLaterActsAsOneFromTheBeginningAndCanBeRemoved) {
  SubmapCollection bent = map_of(kBend);
  SubmapCollection map = map_of({});
  const auto rigid = map.occupied_points();
  EXPECT_TRUE(map.set_pose(2, kT_W_S, kBend));
  EXPECT_EQ(map.occupied_points(), bent.occupied_points());
  EXPECT_TRUE(map.set_pose(2, kT_W_S));
  EXPECT_EQ(map.occupied_points(), rigid);
}

TEST(BentSubmap, AnImpossibleBendIsRefused) {
  SubmapCollection map = map_of({});
  Bend broken;
  broken.T_S_end.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(map.set_pose(2, kT_W_S, broken), std::invalid_argument);
  EXPECT_THROW(map.add(entry_of(4, broken)), std::invalid_argument);
  EXPECT_TRUE(map.find(2)->bend.is_rigid());
}
