// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <thread>

#include "content_builder.hpp"
#include "submap/distance/distance_cache.hpp"
#include "voxnav/submap/submap_collection.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;
using submap::DistanceCache;
using submap::Submap;
using submap::SubmapCollection;

namespace {

std::shared_ptr<Submap> random_submap(unsigned seed) {
  return Submap::from_content(test::random_content(seed, 48, 0.02, 0.3, 0.4),
                              geometry::from_position_yaw({1, 2, 3}, 0.5), {});
}

std::vector<Vec3> random_points(int count) {
  std::mt19937 rng(3);
  std::vector<Vec3> out;
  out.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) out.push_back(test::random_in(&rng, {-14, -14, -14}, {14, 14, 14}));
  return out;
}

std::vector<double> distances_of(const Submap& field, const std::vector<Vec3>& points) {
  std::vector<double> out;
  for (const Vec3& p : points) {
    out.push_back(-1e9);
    field.sample(p, &out.back(), nullptr);
  }
  return out;
}

submap::SubmapEntry entry_of(std::uint32_t id, const Pose& T_W_S) {
  submap::SubmapEntry entry;
  entry.id = id;
  entry.end_ns = id;
  entry.T_W_S = T_W_S;
  entry.submap = random_submap(id);
  return entry;
}

}  // namespace

TEST(Paging, ASubmapOnDiskAnswersTheSame) {
  const std::string path = ::testing::TempDir() + "voxnav_page_" + std::to_string(::getpid());
  const auto points = random_points(3000);
  {
    const auto field = random_submap(1);
    const auto before = distances_of(*field, points);
    const std::size_t bytes = field->memory_bytes();
    field->page_out(path);
    EXPECT_FALSE(field->is_resident());
    EXPECT_LT(field->memory_bytes(), bytes / 10);
    EXPECT_EQ(distances_of(*field, points), before);
    EXPECT_TRUE(field->is_resident());
    field->page_out(path);
    EXPECT_EQ(field->occupied_points(), random_submap(1)->occupied_points());
  }
  EXPECT_NE(::access(path.c_str(), F_OK), 0) << "the file goes with the submap";
}

TEST(Paging, ABrokenPageIsAnErrorAndNotUnknownSpace) {
  const std::string path = ::testing::TempDir() + "voxnav_broken_page_" + std::to_string(::getpid());
  const auto field = random_submap(1);
  field->page_out(path);
  ASSERT_EQ(::truncate(path.c_str(), 100), 0);
  EXPECT_THROW(distances_of(*field, random_points(1)), std::runtime_error);
  EXPECT_THROW(random_submap(2)->page_out("/nonexistent/page"), std::runtime_error);
}

TEST(DistanceCache, IsBoundedAndDoesNotChangeDistances) {
  const auto points = random_points(4000);
  const auto field = random_submap(4);
  const auto expected = distances_of(*field, points);
  const std::size_t limit = DistanceCache::limit_bytes();
  DistanceCache::set_limit_bytes(4 * sizeof(submap::DistanceBlock));
  const auto starved = random_submap(4);
  std::vector<double> found[2];
  std::thread other([&] { found[0] = distances_of(*starved, points); });
  found[1] = distances_of(*starved, points);
  other.join();
  EXPECT_EQ(found[0], expected);
  EXPECT_EQ(found[1], expected);
  EXPECT_LE(DistanceCache::used_bytes(), 6 * sizeof(submap::DistanceBlock));
  DistanceCache::set_limit_bytes(limit);
}

TEST(SubmapCollection, RaysStopAtTheFirstVoxelThatIsNotFree) {
  test::ContentBuilder builder(0.4);
  for (int x = 0; x < 40; ++x) builder.set_free({x, 0, 0});
  builder.set_occupied({30, 0, 0});
  submap::SubmapEntry entry;
  entry.id = 1;
  entry.submap = Submap::from_content(builder.build(), Pose::Identity(), {});
  SubmapCollection collection({});
  collection.add(entry);
  auto ray = collection.cast_ray({0.2, 0.2, 0.2}, {15.8, 0.2, 0.2});
  EXPECT_EQ(ray.state, containers::VoxelState::kOccupied);
  EXPECT_NEAR(ray.distance_m, 12.0 - 0.2, 1e-9);
  ray = collection.cast_ray({0.2, 0.2, 0.2}, {11.0, 0.2, 0.2});
  EXPECT_EQ(ray.state, containers::VoxelState::kFree);
  EXPECT_NEAR(ray.distance_m, 10.8, 1e-9);
  ray = collection.cast_ray({0.2, 0.2, 0.2}, {0.2, 2.0, 0.2});
  EXPECT_EQ(ray.state, containers::VoxelState::kUnknown);
  EXPECT_NEAR(ray.distance_m, 0.2, 1e-9);
  EXPECT_THROW(collection.cast_ray({0, 0, 0}, {1e9, 0, 0}), std::invalid_argument);
  EXPECT_THROW(collection.cast_ray({0, std::nan(""), 0}, {1, 0, 0}), std::invalid_argument);
}

TEST(SubmapCollection, GradientPointsAwayFromTheNearestSurface) {
  SubmapCollection collection({});
  collection.add(entry_of(1, geometry::from_position_yaw({3, 1, 0}, 0.4)));
  const auto points = collection.occupied_points();
  int checked = 0;
  for (const Vec3& p : random_points(300)) {
    const auto gradient = collection.gradient(p, 5.0);
    ASSERT_EQ(gradient.has_value(), collection.state(p) != containers::VoxelState::kUnknown);
    if (!gradient || gradient->isZero()) continue;
    const double distance = *collection.distance(p, 5.0);
    double nearest = 1e9;
    for (const auto& q : points) nearest = std::min(nearest, (q.cast<double>() - (p - distance * *gradient)).norm());
    ASSERT_LT(nearest, 1e-5);
    ++checked;
  }
  EXPECT_GT(checked, 50);
}
