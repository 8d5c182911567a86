// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "voxnav_simulation/depth_camera.hpp"
#include "world_test_tools.hpp"

namespace voxnav_simulation {
namespace {

DepthCameraConfig perfect_camera() {
  DepthCameraConfig config;
  config.noise_per_m = config.dropout_ratio = 0.0;
  config.width = 64;
  config.height = 48;
  return config;
}

/// A camera above flat ground that looks straight down from some height.
Pose down_from(double height_m) {
  Pose T_W_C = Pose::Identity();
  T_W_C.linear() << 0, -1, 0, -1, 0, 0, 0, 0, -1;
  T_W_C.translation() = Vec3(0, 0, height_m);
  return T_W_C;
}

TEST(DepthCameraConfig, LooksAheadWithAxesRightDownForward) {
  const Pose T_B_C = perfect_camera().T_B_C();
  EXPECT_LT((T_B_C.linear() * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-9);
  EXPECT_LT((T_B_C.linear() * Vec3::UnitX() + Vec3::UnitY()).norm(), 1e-9);
  EXPECT_LT((T_B_C.linear() * Vec3::UnitY() + Vec3::UnitZ()).norm(), 1e-9);
}

TEST(DepthCameraConfig, ThePixelsAtTheEdgesSpanTheAngleOfView) {
  const voxnav::cloud::CameraModel camera = DepthCameraConfig().camera();
  EXPECT_NEAR(2.0 * std::atan(0.5 * camera.width / camera.fx), 1.518, 1e-9);
  EXPECT_NEAR(2.0 * std::atan(0.5 * camera.height / camera.fy), 1.012, 1e-9);
}

TEST(DepthCameraModel, DepthIsAlongTheAxisWithinItsRanges) {
  const Scene scene(World(empty_world(), 1));
  const DepthCameraModel camera(perfect_camera(), 1);
  for (const float depth_m : camera.image(scene, down_from(4.0), 0)) EXPECT_NEAR(depth_m, 4.0, 1e-3);
  for (const double height_m : {0.2, 11.0}) {
    for (const float depth_m : camera.image(scene, down_from(height_m), 0)) EXPECT_EQ(depth_m, 0.0F);
  }
}

TEST(DepthCameraModel, NoiseGrowsWithTheSquareOfTheDepth) {
  const Scene scene(World(empty_world(), 1));
  DepthCameraConfig config = perfect_camera();
  config.noise_per_m = 0.005;
  config.dropout_ratio = 0.2;
  const DepthCameraModel camera(config, 1);
  for (const double height_m : {2.0, 6.0}) {
    double sum_sq = 0.0;
    int count = 0, num_none = 0;
    for (std::uint64_t index = 0; index < 4; ++index) {
      for (const float depth_m : camera.image(scene, down_from(height_m), index)) {
        if (depth_m == 0.0F) {
          ++num_none;
        } else {
          sum_sq += std::pow(depth_m - height_m, 2);
          ++count;
        }
      }
    }
    const double expected_m = 0.005 * height_m * height_m;
    EXPECT_NEAR(std::sqrt(sum_sq / count), expected_m, 0.05 * expected_m);
    EXPECT_NEAR(num_none / double(count + num_none), 0.2, 0.02);
  }
  EXPECT_EQ(camera.image(scene, down_from(2.0), 7), camera.image(scene, down_from(2.0), 7));
  EXPECT_NE(camera.image(scene, down_from(2.0), 7), camera.image(scene, down_from(2.0), 8));
}

}  // namespace
}  // namespace voxnav_simulation
