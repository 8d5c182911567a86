// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "base/bytes.hpp"
#include "content_builder.hpp"
#include "voxnav/submap/submap_collection.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Pose;
using geometry::Vec3;
using submap::Submap;
using submap::SubmapCollection;
using submap::SubmapCollectionConfig;
using submap::SubmapEntry;

namespace {

constexpr double kVoxel = 0.4;

/// Returns flat ground at z = 0 seen from above, a wall, and a box-shaped vehicle if asked for.
occupancy::MapContent scene(bool with_vehicle) {
  test::ContentBuilder builder(kVoxel);
  for (int x = -25; x < 25; ++x) {
    for (int y = -25; y < 25; ++y) {
      for (int z = 0; z < 15; ++z) builder.set_free({x, y, z});
      builder.set_occupied({x, y, 0}, Vec3(0, 0, -0.5));
    }
  }
  for (int y = -25; y < 25; ++y) {
    for (int z = 1; z < 12; ++z) builder.set_occupied({20, y, z}, Vec3(-0.25, 0, 0));
  }
  if (!with_vehicle) return builder.build();
  for (int x = -10; x < 10; ++x) {
    for (int y = -3; y < 3; ++y) {
      for (int z = 1; z < 8; ++z) builder.set_occupied({x, y, z});
    }
  }
  return builder.build();
}

bool is_vehicle(const Vec3& p) { return std::abs(p.x()) < 4.2 && std::abs(p.y()) < 1.4 && p.z() > 0.4; }

SubmapEntry entry_of(std::uint32_t id, const occupancy::MapContent& content, const Pose& T_W_S = Pose::Identity()) {
  SubmapEntry entry;
  entry.id = id;
  entry.end_ns = 1000 * static_cast<base::StampNs>(id);
  entry.T_W_S = T_W_S;
  entry.submap = Submap::from_content(content, geometry::from_position_yaw({0.13, -0.3, 0.1}, 0.4), {});
  return entry;
}

std::size_t count_vehicle(const std::vector<geometry::Vec3f>& points, const Pose& T_S_G) {
  std::size_t count = 0;
  for (const auto& p : points) count += is_vehicle(T_S_G.inverse() * p.cast<double>());
  return count;
}

std::string temporary_directory(const char* name) {
  return ::testing::TempDir() + "voxnav_" + name + "_" + std::to_string(::getpid());
}

}  // namespace

TEST(SubmapCollection, OneSubmapKeepsEverySurfacePoint) {
  SubmapCollection collection({});
  const auto content = scene(true);
  const Pose T_W_S = geometry::from_position_yaw({10, 20, 1}, 1.0);
  collection.add(entry_of(1, content, T_W_S));
  EXPECT_EQ(collection.occupied_points().size(), content.num_occupied());
}

TEST(SubmapCollection, MovedVehicleIsGoneAndTheStaticSceneStays) {
  SubmapCollection collection({});
  const auto before = scene(true);
  const auto after = scene(false);
  collection.add(entry_of(1, before));
  const Pose T_S_G = collection.find(1)->submap->T_S_G();
  const std::size_t old_vehicle = count_vehicle(collection.occupied_points(), T_S_G);
  ASSERT_GT(old_vehicle, 500u);
  // The second submap has a small error of its pose, as odometry leaves it.
  collection.add(entry_of(2, after, geometry::from_position_yaw({0.1, -0.05, 0.05}, 0.005)));
  const auto points = collection.occupied_points();
  EXPECT_LE(count_vehicle(points, T_S_G), old_vehicle / 20);
  // Every static surface point of the newer submap is close to a point of the merged map.
  for (const auto& p : collection.find(2)->submap->occupied_points()) {
    const auto distance = collection.distance(collection.find(2)->T_W_S * p.cast<double>(), 2.0);
    if (distance) {
      ASSERT_LT(*distance, kVoxel);
    }
  }
}

TEST(SubmapCollection, OlderFreeSpaceRemovesNothingNewer) {
  SubmapCollection collection({});
  const auto with = scene(true);
  collection.add(entry_of(2, with));
  collection.add(entry_of(1, scene(false)));
  EXPECT_EQ(count_vehicle(collection.occupied_points(), collection.find(2)->submap->T_S_G()),
            count_vehicle(collection.find(2)->submap->occupied_points(), collection.find(2)->submap->T_S_G()));
}

TEST(SubmapCollection, NewerUnknownRemovesNothing) {
  SubmapCollection collection({});
  const auto with = scene(true);
  collection.add(entry_of(1, with));
  test::ContentBuilder small(kVoxel);
  small.set_free({30, 30, 5});
  collection.add(entry_of(2, small.build()));
  EXPECT_EQ(collection.occupied_points().size(), with.num_occupied());
}

TEST(SubmapCollection, MovingASubmapEqualsAddingItThere) {
  const Pose there = geometry::from_position_yaw({7, -3, 0.5}, -0.6);
  SubmapCollection moved({});
  moved.add(entry_of(1, scene(true)));
  moved.add(entry_of(2, scene(false)));
  moved.add(entry_of(3, scene(false), geometry::from_position_yaw({30, 0, 0}, 0.2)));
  moved.update();
  EXPECT_TRUE(moved.set_pose(2, there));
  EXPECT_FALSE(moved.set_pose(17, there));
  SubmapCollection fresh({});
  fresh.add(entry_of(3, scene(false), geometry::from_position_yaw({30, 0, 0}, 0.2)));
  fresh.add(entry_of(2, scene(false), there));
  fresh.add(entry_of(1, scene(true)));
  EXPECT_EQ(moved.occupied_points(), fresh.occupied_points());
}

TEST(SubmapCollection, RemovedSubmapsLeaveNothing) {
  SubmapCollection collection({});
  collection.add(entry_of(1, scene(true)));
  collection.update();
  EXPECT_TRUE(collection.remove(1));
  EXPECT_TRUE(collection.occupied_points().empty());
  EXPECT_TRUE(collection.evidence().blocks().empty());
}

TEST(SubmapCollection, StatesAreUnknownOutsideOfSubmaps) {
  SubmapCollection collection({});
  collection.add(entry_of(1, scene(false)));
  const auto& submap = *collection.find(1)->submap;
  std::mt19937 rng(1);
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p =
        geometry::center_of(geometry::index_of(test::random_in(&rng, {-14, -14, -2}, {14, 14, 8}), kVoxel), kVoxel);
    const VoxelState state = collection.state(p);
    if (submap.state(p) == VoxelState::kUnknown) {
      ASSERT_NE(state, VoxelState::kFree);
    }
    if (submap.state(p) == VoxelState::kFree) {
      ASSERT_NE(state, VoxelState::kUnknown);
    }
  }
  EXPECT_FALSE(collection.distance({500, 0, 0}, 5.0).has_value());
}

TEST(SubmapCollection, OldestIsDroppedBeyondTheLimit) {
  SubmapCollectionConfig config;
  config.max_submaps = 2;
  SubmapCollection collection(config);
  for (std::uint32_t id = 1; id <= 4; ++id) collection.add(entry_of(id, scene(false)));
  EXPECT_EQ(collection.size(), 2u);
  EXPECT_EQ(collection.num_dropped(), 2u);
  EXPECT_EQ(collection.find(2), nullptr);
  EXPECT_NE(collection.find(4), nullptr);
}

TEST(SubmapCollection, SavedAndLoadedAnswersTheSame) {
  const std::string directory = temporary_directory("save");
  SubmapCollection original({});
  SubmapEntry entry = entry_of(5, scene(true), geometry::from_position_yaw({1, 2, 3}, 0.3));
  entry.T_S_B.push_back({77, geometry::from_position_yaw({0, 1, 0}, 0.1)});
  original.add(entry);
  original.save(directory);
  original.add(entry_of(6, scene(false)));
  original.save(directory);
  SubmapCollection copy = SubmapCollection::load(directory);
  ASSERT_EQ(copy.size(), 2u);
  EXPECT_EQ(copy.find(5)->T_S_B.size(), 1u);
  EXPECT_EQ(copy.find(5)->end_ns, 5000);
  EXPECT_EQ(copy.occupied_points(), original.occupied_points());
}

TEST(SubmapCollection, BrokenFilesAreRefusedWithAReasonAndTheRestIsRecovered) {
  const std::string directory = temporary_directory("broken");
  SubmapCollection original({});
  original.add(entry_of(1, scene(true)));
  original.add(entry_of(2, scene(false)));
  original.save(directory);
  const std::string bytes = original.find(2)->submap->to_bytes();
  char name[64];
  std::snprintf(name, sizeof(name), "/submap_%06u_%08x.vxs", 2u, base::crc32(bytes.data(), bytes.size()));
  ASSERT_EQ(::truncate((directory + name).c_str(), static_cast<off_t>(bytes.size() / 2)), 0);
  EXPECT_THROW(SubmapCollection::load(directory), std::invalid_argument);
  std::vector<std::string> problems;
  const SubmapCollection rest = SubmapCollection::load(directory, &problems);
  EXPECT_EQ(rest.size(), 1u);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].find("checksum"), std::string::npos);
  ASSERT_EQ(::truncate((directory + "/index.vxi").c_str(), 30), 0);
  EXPECT_THROW(SubmapCollection::load(directory, &problems), std::invalid_argument);
  EXPECT_THROW(SubmapCollection::load(directory + "_absent"), std::runtime_error);
}

namespace {

/// Returns free space with or without a wire along y at z = 2, as seen from `view`.
SubmapEntry wire_entry(std::uint32_t id, bool with_wire, const Vec3& view, const Pose& T_W_S = Pose::Identity()) {
  test::ContentBuilder builder(kVoxel);
  for (int i = 0; i < 20 * 30 * 10; ++i) builder.set_free({i % 20 - 10, i / 20 % 30 - 15, i / 600});
  for (int y = -15; with_wire && y < 15; ++y) builder.set_occupied({0, y, 5}, Vec3(0.1, 0, -0.2));
  SubmapEntry entry;
  entry.id = id;
  entry.end_ns = id;
  entry.T_W_S = T_W_S;
  entry.T_S_B = {{0, geometry::from_position_yaw(view, 0.0)}};
  entry.submap = Submap::from_content(builder.build(), Pose::Identity(), {});
  return entry;
}

std::size_t points_left(const std::vector<SubmapEntry>& entries) {
  SubmapCollection collection({});
  for (const SubmapEntry& entry : entries) collection.add(entry);
  return collection.occupied_points().size();
}

}  // namespace

TEST(SubmapCollection, AWireThatAMoreDistantViewMissedStays) {
  EXPECT_EQ(points_left({wire_entry(1, true, {5, 0, 2}), wire_entry(2, false, {16, 0, 2})}), 30u);
}

TEST(SubmapCollection, AWireThatAViewAsNearMissedIsRemoved) {
  EXPECT_EQ(points_left({wire_entry(1, true, {5, 0, 2}), wire_entry(2, false, {0.2, 0, 1})}), 0u);
  // The wire is removed as well if the newer view is as near as the older one, and if the newer view is not known.
  EXPECT_EQ(points_left({wire_entry(1, true, {20, 0, 2}), wire_entry(2, false, {19, 0, 2})}), 0u);
  SubmapEntry unknown = wire_entry(2, false, {16, 0, 2});
  unknown.T_S_B.clear();
  EXPECT_EQ(points_left({wire_entry(1, true, {5, 0, 2}), unknown}), 0u);
}

TEST(SubmapCollection, ABoxThatADistantViewMissedIsRemoved) {
  SubmapEntry before = entry_of(1, scene(true));
  SubmapEntry after = entry_of(2, scene(false));
  before.T_S_B = {{0, geometry::from_position_yaw({6, 0, 2}, 0.0)}};
  after.T_S_B = {{0, geometry::from_position_yaw({-30, 0, 2}, 0.0)}};
  SubmapCollection collection({});
  collection.add(before);
  collection.add(after);
  EXPECT_EQ(count_vehicle(collection.occupied_points(), geometry::from_position_yaw({0.13, -0.3, 0.1}, 0.4)), 0u);
}

TEST(SubmapCollection, MovedSubmapsGiveTheMapOfSubmapsAddedThere) {
  SubmapCollection moved({});
  std::vector<SubmapEntry> entries;
  for (std::uint32_t id = 1; id <= 6; ++id) {
    entries.push_back(entry_of(id, scene(id % 2 == 1), geometry::from_position_yaw({0.3 * id, 0.2, 0.0}, 0.1 * id)));
    moved.add(entries.back());
    moved.update();
  }
  SubmapCollection fresh({});
  for (SubmapEntry& entry : entries) {
    entry.T_W_S = geometry::from_position_yaw({-0.2 * entry.id, 0.9, 0.1}, 0.03 * entry.id);
    moved.set_pose(entry.id, entry.T_W_S);
    fresh.add(entry);
  }
  moved.update();
  fresh.update();
  ASSERT_EQ(moved.evidence().blocks().size(), fresh.evidence().blocks().size());
  for (const auto& [index, block] : fresh.evidence().blocks()) {
    const auto* other = moved.evidence().find(index);
    ASSERT_NE(other, nullptr);
    ASSERT_EQ(other->states.free, block.states.free);
    ASSERT_EQ(other->states.occupied, block.states.occupied);
    ASSERT_EQ(other->points.size(), block.points.size());
    ASSERT_EQ(other->removed.size(), block.removed.size());
  }
}

TEST(SubmapCollection, RefusesSubmapsThatTheGridCannotHold) {
  SubmapCollection collection({});
  SubmapEntry far = entry_of(1, scene(false), geometry::from_position_yaw({9e5, 0, 0}, 0.0));
  EXPECT_NO_THROW(collection.add(far));
  test::ContentBuilder coarse(4.0);
  coarse.set_free({0, 0, 0});
  far.submap = Submap::from_content(coarse.build(), Pose::Identity(), {});
  EXPECT_THROW(collection.add(far), std::invalid_argument);
}
