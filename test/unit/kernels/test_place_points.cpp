// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <random>

#include "instruction_sets.hpp"
#include "kernels/place_points.hpp"
#include "kernels/point_sum.hpp"

using namespace voxnav;  // NOLINT: test
using kernels::PointBatch;

namespace {

kernels::PlacementFrame make_frame(float heading) {
  kernels::PlacementFrame frame;
  frame.rotation = Eigen::AngleAxisf(heading, geometry::Vec3f(0.1f, 0.2f, 1.0f).normalized()).toRotationMatrix() * 2.5f;
  frame.origin = geometry::Vec3f(50.3f, 49.8f, 20.0f);
  frame.low = Eigen::Array3f(0.01f, 0.01f, 0.01f);
  frame.high = Eigen::Array3f(99.9f, 99.9f, 39.9f);
  frame.nearest_m = 0.5f;
  frame.farthest_m = 26.0f;
  return frame;
}

PointBatch random_batch(unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> place(-25.0f, 25.0f);
  PointBatch batch;
  for (std::size_t i = 0; i < PointBatch::kSize; ++i) {
    batch.x[i] = place(rng);
    batch.y[i] = place(rng);
    batch.z[i] = 0.3f * place(rng);
  }
  batch.x[3] = std::numeric_limits<float>::quiet_NaN();
  batch.y[17] = std::numeric_limits<float>::infinity();
  batch.x[40] = batch.y[40] = batch.z[40] = 0.0f;
  batch.z[77] = -1e30f;
  return batch;
}

}  // namespace

TEST(PlacePoints, EqualsTheReference) {
  test::with_every_instruction_set([] {
    const auto placed = std::make_unique<kernels::PlacedBatch>(), expected = std::make_unique<kernels::PlacedBatch>();
    std::size_t num_ends = 0;
    for (unsigned seed = 0; seed < 20; ++seed) {
      const PointBatch batch = random_batch(seed);
      const kernels::PlacementFrame frame = make_frame(0.3f * static_cast<float>(seed));
      kernels::place_points(batch, frame, placed.get());
      kernels::reference::place_points(batch, frame, expected.get());
      for (std::size_t i = 0; i < PointBatch::kSize; ++i) {
        ASSERT_EQ(placed->is_end[i], expected->is_end[i]) << i;
        num_ends += placed->is_end[i] != 0 ? 1 : 0;
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_EQ(placed->voxel[axis][i], expected->voxel[axis][i]) << i;
          ASSERT_EQ(placed->offset[axis][i], expected->offset[axis][i]) << i;
        }
      }
    }
    EXPECT_GT(num_ends, 1000u);
  });
}

TEST(PointSum, EqualsTheReference) {
  std::mt19937 rng(4);
  std::uniform_real_distribution<float> offset(-0.5f, 0.5f);
  kernels::PointSum sum;
  kernels::reference::PointSum expected;
  for (int i = 0; i < 1000; ++i) {
    const float x = offset(rng), y = offset(rng), z = offset(rng);
    sum.add(x, y, z);
    expected.add(x, y, z);
  }
  const float firsts[4] = {expected.x, expected.y, expected.z, expected.count};
  const float seconds[4] = {expected.xx, expected.xy, expected.xz, expected.x};
  const float thirds[4] = {expected.xy, expected.yy, expected.yz, expected.y};
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(sum.first[i], firsts[i]);
    EXPECT_EQ(sum.second[i], seconds[i]);
    EXPECT_EQ(sum.third[i], thirds[i]);
  }
  EXPECT_EQ(sum.zz, expected.zz);
}
