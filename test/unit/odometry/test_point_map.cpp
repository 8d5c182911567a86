// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "odometry/point_map.hpp"
#include "steps.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::Vec3f;
using odometry::PointMap;
using odometry::PointMapOptions;
using odometry::Shape;

std::vector<Vec3f> random_points(int count, float half_side, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> in(-half_side, half_side);
  std::vector<Vec3f> out;
  out.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) out.emplace_back(in(random), in(random), in(random));
  return out;
}

/// Returns a grid of points on the plane z = 0.
std::vector<Vec3f> floor_points(float step) {
  std::vector<Vec3f> out;
  const std::vector<double> side = test::steps(-2.0, 2.0 + 0.5 * step, step);
  for (const double x : side) {
    for (const double y : side) out.emplace_back(voxnav::geometry::Vec3(x, y, 0.0).cast<float>());
  }
  return out;
}

TEST(PointMap, FindsTheNearestPointThatBruteForceFinds) {
  PointMapOptions options;
  options.max_points_per_voxel = 40;
  options.voxel_size_m = 0.5;
  PointMap map(options);
  const std::vector<Vec3f> points = random_points(300, 2.0F, 3);  // so sparse that no point is too near to another
  map.insert(points);
  std::vector<Vec3f> stored;
  for (const Vec3f& p : points) {
    if (odometry::MapPoint* m = map.nearest(p, 0.001)) stored.push_back(m->position);
  }
  ASSERT_GT(stored.size(), 200u);
  for (const Vec3f& q : random_points(500, 2.5F, 4)) {
    for (double limit : {0.1, 0.4, 0.9}) {
      float best = static_cast<float>(limit * limit);
      bool any = false;
      for (const Vec3f& p : stored) {
        if ((p - q).squaredNorm() < best) {
          best = (p - q).squaredNorm();
          any = true;
        }
      }
      const odometry::MapPoint* found = map.nearest(q, limit);
      ASSERT_EQ(found != nullptr, any);
      if (!found) continue;
      EXPECT_FLOAT_EQ((found->position - q).squaredNorm(), best);
    }
  }
}

TEST(PointMap, FitsPlanesWithTheirNormal) {
  PointMap map(PointMapOptions{});
  map.insert(floor_points(0.18F));
  odometry::MapPoint* point = map.nearest(Vec3f(0.1F, 0.1F, 0.05F), 0.5);
  ASSERT_NE(point, nullptr);
  map.update_shape(point, Vec3f::UnitZ(), 1);
  EXPECT_EQ(point->shape, Shape::kPlane);
  EXPECT_NEAR(std::abs(point->direction.z()), 1.0F, 1e-5F);
  EXPECT_NEAR(point->anchor.z(), 0.0F, 1e-5F);
}

// A ring of the sensor on the ground is a line that moves with the sensor, so it must not constrain the pose.
TEST(PointMap, FitsUprightLinesButNotSensorRings) {
  for (bool upright : {true, false}) {
    PointMap map(PointMapOptions{});
    std::vector<Vec3f> line;
    for (int i = -40; i <= 40; ++i) {
      const float s = 0.05F * static_cast<float>(i);
      line.push_back(upright ? Vec3f(3, 0, s) : Vec3f(3, s, 0));
    }
    map.insert(line);
    odometry::MapPoint* point = map.nearest(Vec3f(3, 0, 0), 0.5);
    ASSERT_NE(point, nullptr);
    map.update_shape(point, Vec3f::UnitZ(), 1);
    EXPECT_EQ(point->shape, upright ? Shape::kLine : Shape::kUnknown);
  }
}

TEST(PointMap, StaysBoundedAndKeepsWhatIsNear) {
  PointMapOptions options;
  options.max_voxels = 2000;
  PointMap map(options);
  for (int i = 0; i < 20; ++i) {
    std::vector<Vec3f> points = random_points(2000, 10.0F, static_cast<std::uint32_t>(i));
    for (Vec3f& p : points) p.x() += 5.0F * static_cast<float>(i);
    map.keep_around(Vec3f(5.0F * static_cast<float>(i), 0, 0), 40.0);
    map.insert(points);
    EXPECT_LE(map.num_voxels(), 2000u);
  }
  map.keep_around(Vec3f(95, 0, 0), 5.0);
  EXPECT_EQ(map.nearest(Vec3f(60, 0, 0), 1.0), nullptr);
  EXPECT_NE(map.nearest(Vec3f(95, 0, 0), 1.2), nullptr);
}

TEST(PointMap, IgnoresPointsBeyondTheVoxelIndices) {
  PointMap map(PointMapOptions{});
  const float infinity = std::numeric_limits<float>::infinity();
  map.insert({Vec3f(std::nanf(""), 0, 0), Vec3f(infinity, 0, 0), Vec3f(1e9F, 0, 0)});
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.nearest(Vec3f(std::nanf(""), 0, 0), 1.0), nullptr);
}

TEST(Downsample, KeepsTheFirstPointOfEachVoxel) {
  odometry::Downsampler downsampler;
  for (int again = 0; again < 2; ++again) {
    std::vector<Vec3f> out;
    downsampler.run({Vec3f(0.1F, 0, 0), Vec3f(0.2F, 0, 0), Vec3f(-0.1F, 0, 0), Vec3f(1.1F, 0, 0)}, 1.0, &out);
    ASSERT_EQ(out.size(), 3u);
    EXPECT_EQ(out[0].x(), 0.1F);
    EXPECT_EQ(out[1].x(), -0.1F);
    EXPECT_EQ(out[2].x(), 1.1F);
  }
}

}  // namespace
