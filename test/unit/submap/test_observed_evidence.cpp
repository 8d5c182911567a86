// SPDX-License-Identifier: BSD-3-Clause
// The merged map is made of what each submap observed itself. Content that a submap only remembers was placed by an
// older pose that has drifted, and correcting the pose of the submap does not correct it.
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "scan_maker.hpp"
#include "steps.hpp"
#include "voxnav/submap/submap_collection.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Pose;
using geometry::Vec3;
using submap::Submap;
using submap::SubmapCollection;
using submap::SubmapEntry;

namespace {

constexpr double kVoxel = 0.4;

SubmapEntry entry_of(std::uint32_t id, const occupancy::MapContent& content, const Pose& T_W_S = Pose::Identity()) {
  SubmapEntry entry;
  entry.id = id;
  entry.end_ns = id;
  entry.T_W_S = T_W_S;
  entry.submap = Submap::from_content(content, Pose::Identity(), {});
  return entry;
}

/// Returns free space with a wall perpendicular to x, which the submap observed or only remembers.
occupancy::MapContent wall_at(int x_wall, bool is_remembered) {
  test::ContentBuilder builder(kVoxel);
  for (int z = 0; z < 8; ++z) {
    for (int y = -12; y < 12; ++y) {
      for (int x = -12; x < x_wall; ++x) {
        builder.set_free({x, y, z});
        if (is_remembered) builder.set_remembered({x, y, z});
      }
      builder.set_occupied({x_wall, y, z});
      if (is_remembered) builder.set_observed({x_wall, y, z}, Vec3::Zero(), 0);
    }
  }
  return builder.build();
}

/// Returns points of a wall in W along x, 8 m long, with several points in each voxel.
std::vector<Vec3> wall(double x_from) {
  std::vector<Vec3> out;
  for (const double x : test::steps(x_from + 0.05, x_from + 8.0, 0.1)) {
    for (const double z : test::steps(0.25, 2.0, 0.1)) out.emplace_back(x, 4.03, z);
  }
  return out;
}

}  // namespace

/// A local map sees two walls, and its pose has drifted by 0.9 m when it sees the second.
TEST(ObservedEvidence, AMapOfCorrectedSubmapsIsNotDoubled) {
  occupancy::LocalMap map(occupancy::LocalMapConfig{});
  const Vec3 drift(0.1, 0.9, 0.0);
  std::vector<Vec3> truth = wall(0.0);
  for (int i = 0; i < 20; ++i) test::insert_from(&map, {0.2 * i, 0.0, 1.0}, truth);
  SubmapCollection collection({});
  collection.add(entry_of(1, map.hand_over()));
  std::vector<Vec3> seen = wall(9.0);
  truth.insert(truth.end(), seen.begin(), seen.end());
  for (Vec3& p : seen) p += drift;
  for (int i = 0; i < 20; ++i) test::insert_from(&map, Vec3(9.0 + 0.2 * i, 0.0, 1.0) + drift, seen);
  collection.add(entry_of(2, map.hand_over(), test::at(-drift.x(), -drift.y(), 0.0)));
  std::size_t right = 0;
  const auto points = collection.occupied_points();
  for (const auto& p : points) {
    right += std::any_of(truth.begin(), truth.end(),
                         [&](const Vec3& q) { return (q - p.cast<double>()).norm() < 0.5 * kVoxel; });
  }
  ASSERT_GT(points.size(), 150u);
  EXPECT_EQ(right, points.size());
}

TEST(ObservedEvidence, RememberedFreeSpaceRemovesNothing) {
  SubmapCollection collection({});
  const auto content = wall_at(0, false);
  collection.add(entry_of(1, content));
  collection.add(entry_of(2, wall_at(8, true)));
  EXPECT_EQ(collection.occupied_points().size(), content.num_occupied());
  EXPECT_EQ(collection.state({1.0, 0.2, 0.2}), VoxelState::kUnknown);
  EXPECT_TRUE(collection.changes(1).empty());
  collection.add(entry_of(3, wall_at(8, false)));  // the same content, but observed
  EXPECT_EQ(collection.state({0.2, 0.2, 1.0}), VoxelState::kFree);
  EXPECT_FALSE(collection.changes(1).empty());
}

namespace {

/// Returns ground at z = 0.3 m that was seen from above.
occupancy::MapContent ground() {
  test::ContentBuilder builder(kVoxel);
  for (int i = 0; i < 24 * 24; ++i) {
    builder.set_occupied({i % 24 - 12, i / 24 - 12, 0}, Vec3(0, 0, 0.25));
    builder.set_free({i % 24 - 12, i / 24 - 12, 1});
  }
  return builder.build();
}

/// Returns free space alone, from the layer of voxels `lowest` up to `highest`.
occupancy::MapContent air(int lowest, int highest) {
  test::ContentBuilder builder(kVoxel);
  for (int i = 0; i < 24 * 24; ++i) {
    for (int z = lowest; z <= highest; ++z) builder.set_free({i % 24 - 12, i / 24 - 12, z});
  }
  return builder.build();
}

}  // namespace

/// Between the rings of a LiDAR on the ground, rays cross voxels of the ground without a hit.
TEST(ObservedEvidence, GroundStaysUnderRaysThatGrazeIt) {
  SubmapCollection collection({});
  const auto content = ground();
  collection.add(entry_of(1, content));
  collection.add(entry_of(2, air(0, 3)));
  EXPECT_EQ(collection.occupied_points().size(), content.num_occupied());
  EXPECT_TRUE(collection.changes(1).empty());
}

TEST(ObservedEvidence, SurfacesWithFreeSpaceAboveAndBelowAreRemoved) {
  SubmapCollection collection({});
  collection.add(entry_of(1, ground()));
  collection.add(entry_of(2, air(0, 3)));
  collection.add(entry_of(3, air(-1, -1)));  // free space below the ground, after free space above it
  EXPECT_TRUE(collection.occupied_points().empty());
  ASSERT_EQ(collection.changes(1).size(), 1u);
  EXPECT_EQ(collection.changes(1).front().submap_id, 3u);
}

TEST(ObservedEvidence, ADoubtEndsWhereASurfaceIsSeenAgain) {
  SubmapCollection collection({});
  const auto content = ground();
  collection.add(entry_of(1, content));
  collection.add(entry_of(2, air(0, 3)));
  SubmapEntry again = entry_of(3, content, test::at(0.0, 0.0, 0.15));  // near, although in the voxels above
  collection.add(again);
  collection.add(entry_of(4, air(-1, -1)));
  std::size_t kept = 0;
  for (const auto& p : collection.occupied_points()) kept += p.z() < kVoxel;
  EXPECT_EQ(kept, content.num_occupied());
}

namespace {

/// Returns surfaces in one layer of voxels, x from `first` to `last`, `depth` voxels deep along y.
occupancy::MapContent shelf(int first, int last, int depth) {
  test::ContentBuilder builder(kVoxel);
  for (int x = first; x <= last; ++x) {
    for (int y = 0; y < depth; ++y) builder.set_occupied({x, y, 5});
  }
  return builder.build();
}

/// Returns free space below and above the layer of the shelf, without the layer itself, and the shelf from `first` on.
occupancy::MapContent air_past_the_shelf(int lowest, int highest, int first) {
  test::ContentBuilder builder(kVoxel);
  for (int i = 0; i < 24 * 24; ++i) {
    for (int z = lowest; z <= highest; ++z) {
      if (z != 5) builder.set_free({i % 24 - 12, i / 24 - 12, z});
    }
  }
  for (int x = first; x < 12; ++x) builder.set_occupied({x, 1, 5});
  return builder.build();
}

std::size_t left_of(const occupancy::MapContent& before, const occupancy::MapContent& after) {
  SubmapCollection collection({});
  collection.add(entry_of(1, before));
  collection.add(entry_of(2, after));
  std::size_t left = 0;
  for (const auto& p : collection.occupied_points()) left += p.x() < 4.0 ? 1 : 0;
  return left;
}

constexpr int kNowhere = 12;

}  // namespace

/// From one height a sparse sensor looks between the same voxels again and again.
TEST(ObservedEvidence, SurfacesThatBeamsPassBelowAndAboveAreRemoved) {
  const std::size_t corners = 4;  // have few neighbours, so that they count as thin
  EXPECT_EQ(left_of(shelf(-8, 8, 3), air_past_the_shelf(0, 8, kNowhere)), corners);
}

TEST(ObservedEvidence, SurfacesThatBeamsPassOnOneSideStay) {
  EXPECT_EQ(left_of(shelf(-8, 8, 3), air_past_the_shelf(0, 5, kNowhere)), 17u * 3u);
  EXPECT_EQ(left_of(shelf(-8, 8, 3), air_past_the_shelf(6, 8, kNowhere)), 17u * 3u);
}

TEST(ObservedEvidence, SurfacesThatBeamsPassStayNearWhatIsSeenOfThem) {
  // The shelf is seen again from x = 0 on: what is nearer than two clearing distances to that stays.
  const std::size_t of_the_rest = left_of(shelf(0, 8, 3), air_past_the_shelf(0, 8, 0)), corners = 2, near = 3;
  EXPECT_EQ(left_of(shelf(-8, 8, 3), air_past_the_shelf(0, 8, 0)) - of_the_rest, corners + near);
}

TEST(ObservedEvidence, AWireBetweenBeamsStays) {
  EXPECT_EQ(left_of(shelf(-8, 8, 1), air_past_the_shelf(0, 8, kNowhere)), 17u);
}

TEST(ObservedEvidence, MemoryCountsWhereNothingElseIsKnown) {
  SubmapCollection collection({});
  const auto content = wall_at(0, true);
  collection.add(entry_of(7, content));  // submap 6 is missing, as after a restart
  EXPECT_EQ(collection.occupied_points().size(), content.num_occupied());
  EXPECT_EQ(collection.state({-1.0, 0.2, 0.2}), VoxelState::kFree);
  // Once submap 6 arrives, its own observations replace what submap 7 remembers.
  collection.add(entry_of(6, wall_at(2, false)));
  EXPECT_EQ(collection.state({0.2, 0.2, 1.0}), VoxelState::kFree);
  for (const auto& p : collection.occupied_points()) ASSERT_NEAR(p.x(), 2.5 * kVoxel, 1e-3);
  collection.remove(6);
  EXPECT_EQ(collection.occupied_points().size(), content.num_occupied());
}

TEST(ObservedEvidence, MemoryOfAnotherFlightDoesNotOverrideAMap) {
  SubmapCollection collection({});
  const auto content = wall_at(0, false);
  collection.add(entry_of(1, content));
  SubmapEntry later = entry_of(2, wall_at(2, true));
  later.flight = 1;
  collection.add(later);
  EXPECT_EQ(collection.occupied_points().size(), content.num_occupied());
  EXPECT_EQ(collection.state({0.2, 0.2, 0.2}), VoxelState::kOccupied);
}

namespace {

/// Returns a wall perpendicular to x that was observed, and one that is only remembered.
occupancy::MapContent with_memory(int x_wall, int x_remembered) {
  test::ContentBuilder builder(kVoxel);
  for (int z = 0; z < 8; ++z) {
    for (int y = -12; y < 12; ++y) {
      builder.set_occupied({x_wall, y, z});
      builder.set_occupied({x_remembered, y, z});
      builder.set_observed({x_remembered, y, z}, Vec3::Zero(), 0);
    }
  }
  return builder.build();
}

std::size_t count_at(SubmapCollection* collection, double x_m) {
  std::size_t count = 0;
  for (const auto& p : collection->occupied_points()) count += std::abs(p.x() - x_m) < 0.1;
  return count;
}

}  // namespace

/// Submaps 1 and 3 observed the wall at voxel 2, which submap 2 remembers at voxel 4. When submap 1 is dropped, submap
/// 3 still holds the wall, so that the memory of submap 2 must not count.
TEST(ObservedEvidence, MemoryOfADroppedSubmapDoesNotCountWhereAnotherObservedThePlace) {
  submap::SubmapCollectionConfig config;
  config.max_submaps = 2;
  SubmapCollection collection(config);
  collection.add(entry_of(1, wall_at(2, false)));
  collection.add(entry_of(2, with_memory(40, 4)));
  collection.update();
  collection.add(entry_of(3, wall_at(2, false)));
  ASSERT_EQ(collection.num_dropped(), 1u);
  const std::size_t whole = wall_at(2, false).num_occupied();
  EXPECT_EQ(count_at(&collection, 2.5 * kVoxel), whole);
  EXPECT_EQ(count_at(&collection, 4.5 * kVoxel), 0u);  // what submap 2 remembers of submap 1
  EXPECT_EQ(count_at(&collection, 40.5 * kVoxel), whole);
}

/// When the only submap that observed a wall is dropped, the memory of the next one keeps the wall in the map until
/// another submap observes the place.
TEST(ObservedEvidence, MemoryReplacesADroppedSubmapUntilAnotherObservesThePlace) {
  submap::SubmapCollectionConfig config;
  config.max_submaps = 2;
  SubmapCollection collection(config);
  collection.add(entry_of(1, wall_at(2, false)));
  collection.add(entry_of(2, with_memory(40, 4)));
  collection.add(entry_of(3, with_memory(80, 40)));
  collection.update();
  const std::size_t whole = wall_at(2, false).num_occupied();
  EXPECT_EQ(count_at(&collection, 4.5 * kVoxel), whole);
  config.max_submaps = 5;
  SubmapCollection larger(config);  // a collection that submap 1 never reached
  for (const std::uint32_t id : {2u, 3u}) larger.add(*collection.find(id));
  larger.update();
  EXPECT_EQ(count_at(&larger, 4.5 * kVoxel), whole);
  larger.add(entry_of(4, wall_at(2, false)));
  larger.update();
  EXPECT_EQ(count_at(&larger, 4.5 * kVoxel), 0u);
  EXPECT_EQ(count_at(&larger, 2.5 * kVoxel), whole);
  // The result does not depend on the order, and removing the submap undoes it.
  SubmapCollection fresh(config);
  for (const std::uint32_t id : {4u, 3u, 2u}) fresh.add(*larger.find(id));
  EXPECT_EQ(fresh.occupied_points(), larger.occupied_points());
  larger.remove(4);
  EXPECT_EQ(count_at(&larger, 4.5 * kVoxel), whole);
  EXPECT_EQ(count_at(&larger, 2.5 * kVoxel), 0u);
}
