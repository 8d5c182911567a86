// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "voxnav/cloud/cloud_filter.hpp"
#include "voxnav/cloud/depth_cloud.hpp"
#include "voxnav/cloud/open_beams.hpp"
#include "voxnav/cloud/sweep.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using cloud::camera_of;
using cloud::CameraInfo;
using cloud::CameraModel;
using cloud::DepthCloud;
using cloud::DepthCloudConfig;
using cloud::DepthImage;

constexpr std::uint32_t kWidth = 64, kHeight = 48;

CameraInfo good_info() {
  CameraInfo info;
  info.width = kWidth;
  info.height = kHeight;
  info.P = {34.0, 0, 31.5, 0, 0, 33.0, 23.5, 0, 0, 0, 1, 0};
  return info;
}

/// An image that owns its pixels, in rows that are longer than needed.
template <class Number>
struct OwnedImage {
  explicit OwnedImage(const char* encoding, Number value) : pixels((kWidth + 3) * kHeight, value) {
    image.encoding = encoding;
    image.width = kWidth;
    image.height = kHeight;
    image.step = (kWidth + 3) * sizeof(Number);
    image.data = reinterpret_cast<const std::uint8_t*>(pixels.data());
    image.size = pixels.size() * sizeof(Number);
  }
  Number& at(std::uint32_t u, std::uint32_t v) { return pixels[v * (kWidth + 3) + u]; }
  std::vector<Number> pixels;
  DepthImage image;
};

std::vector<geometry::Vec3f> points_of(DepthCloud* depth, const DepthImage& image, const CameraModel& camera) {
  std::vector<std::uint8_t> bytes;
  depth->convert(image, camera, &bytes);
  return cloud::read_sweep({depth->layout(camera), bytes.data(), bytes.size()}).points;
}

std::string problem_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

TEST(DepthCloud, PutsPixelsWhereTheCameraSawThem) {
  const CameraModel camera = camera_of(good_info());
  OwnedImage<std::uint16_t> millimetres("16UC1", 0);
  OwnedImage<float> metres("32FC1", 0.0F);
  const auto depth_mm = [](std::uint32_t u, std::uint32_t v) { return 500 + 37 * u + 11 * v; };
  for (std::uint32_t v = 0; v < kHeight; ++v) {
    for (std::uint32_t u = 0; u < kWidth; ++u) {
      millimetres.at(u, v) = static_cast<std::uint16_t>(depth_mm(u, v));
      metres.at(u, v) = static_cast<float>(depth_mm(u, v)) * 0.001F;
    }
  }
  for (const int step : {1, 3}) {
    DepthCloudConfig config;
    config.row_step = config.column_step = step;
    DepthCloud depth(config);
    for (const DepthImage& image : {millimetres.image, metres.image}) {
      const auto points = points_of(&depth, image, camera);
      std::size_t i = 0;
      for (std::uint32_t v = 0; v < kHeight; v += static_cast<std::uint32_t>(step)) {
        for (std::uint32_t u = 0; u < kWidth; u += static_cast<std::uint32_t>(step), ++i) {
          const double z = 0.001 * depth_mm(u, v);
          ASSERT_LT(i, points.size());
          EXPECT_NEAR(points[i].x(), (u - 31.5) / 34.0 * z, 1e-5);
          EXPECT_NEAR(points[i].y(), (v - 23.5) / 33.0 * z, 1e-5);
          EXPECT_NEAR(points[i].z(), z, 1e-5);
        }
      }
      EXPECT_EQ(i, points.size());
    }
  }
}

TEST(DepthCloud, PixelsWithoutDepthAreNoPoints) {
  DepthCloud depth;
  const CameraModel camera = camera_of(good_info());
  OwnedImage<std::uint16_t> millimetres("mono16", 0);
  millimetres.at(2, 2) = 65535;
  for (const auto& point : points_of(&depth, millimetres.image, camera)) EXPECT_FALSE(point.allFinite());
  using Limits = std::numeric_limits<float>;
  for (const float none : {0.0F, -1.0F, Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
    const OwnedImage<float> metres("32FC1", none);
    for (const auto& point : points_of(&depth, metres.image, camera)) EXPECT_FALSE(point.allFinite());
  }
}

TEST(DepthCloud, BinningAndRegionOfInterestMoveTheIntrinsics) {
  CameraInfo info = good_info();
  info.binning_x = info.binning_y = 2;
  info.roi_x = 16;
  info.roi_y = 8;
  info.roi_width = 32;
  info.roi_height = 24;
  const CameraModel camera = camera_of(info);
  EXPECT_EQ(camera.width, 16u);
  EXPECT_EQ(camera.height, 12u);
  EXPECT_DOUBLE_EQ(camera.fx, 17.0);
  EXPECT_DOUBLE_EQ(camera.cx, (31.5 - 16) / 2);
  EXPECT_DOUBLE_EQ(camera.cy, (23.5 - 8) / 2);
}

TEST(DepthCloud, SaysWhatACameraInfoLacks) {
  CameraInfo info = good_info();
  info.width = 0;
  EXPECT_NE(problem_of([&] { camera_of(info); }).find("no size"), std::string::npos);
  info = good_info();
  info.K = {30.0, 0, 31.0, 0, 30.0, 23.0, 0, 0, 1};
  info.P = {};
  EXPECT_DOUBLE_EQ(camera_of(info).fx, 30.0);
  info.K = {};
  EXPECT_NE(problem_of([&] { camera_of(info); }).find("no intrinsics"), std::string::npos);
  info.K[0] = info.K[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(problem_of([&] { camera_of(info); }).find("no intrinsics"), std::string::npos);
}

TEST(DepthCloud, SaysWhatIsWrongWithAnImage) {
  DepthCloud depth;
  const CameraModel camera = camera_of(good_info());
  const OwnedImage<float> good("32FC1", 1.0F);
  const auto problem = [&](const std::function<void(DepthImage*)>& spoil) {
    DepthImage image = good.image;
    spoil(&image);
    return problem_of([&] {
      std::vector<std::uint8_t> bytes;
      depth.convert(image, camera, &bytes);
    });
  };
  EXPECT_EQ(problem([](DepthImage*) {}), "");
  EXPECT_NE(problem([](DepthImage* i) { i->encoding = "bgr8"; }).find("'bgr8'"), std::string::npos);
  EXPECT_NE(problem([](DepthImage* i) { i->width = 32; }).find("32 x 48"), std::string::npos);
  EXPECT_NE(problem([](DepthImage* i) { i->size -= std::size_t{4} * kWidth; }).find("too few"), std::string::npos);
  EXPECT_NE(problem([](DepthImage* i) { i->step = 7; }).find("too few"), std::string::npos);
  EXPECT_NE(problem([](DepthImage* i) { i->is_big_endian = true; }).find("big-endian"), std::string::npos);
}

TEST(DepthCloud, PixelsWithoutDepthSayNothingUnlessTheyBearBeams) {
  const CameraModel camera = camera_of(good_info());
  OwnedImage<float> image("32FC1", 0.0F);
  for (std::uint32_t v = 0; v < kHeight; ++v) {
    for (std::uint32_t u = 0; u < kWidth / 2; ++u) image.at(u, v) = 2.0F;  // a wall on the left, nothing on the right
  }
  for (const bool has_beams : {false, true}) {
    DepthCloudConfig config;
    config.row_step = config.column_step = 1;
    config.has_beams = has_beams;
    DepthCloud depth(config);
    std::vector<std::uint8_t> bytes;
    depth.convert(image.image, camera, &bytes);
    const cloud::RawCloudView view(depth.layout(camera), bytes.data(), bytes.size());
    cloud::CloudFilter filter{cloud::CloudFilterConfig()};
    EXPECT_EQ(filter.apply(view).points.size(), kHeight * kWidth / 2);
    cloud::OpenBeams beams({true, 1, 2, 1, 1});
    const auto found = beams.find(view);
    if (!has_beams) {
      EXPECT_TRUE(found.empty());
      continue;
    }
    // Two columns beside the wall and, as columns are taken to run around, two at the other end.
    EXPECT_EQ(found.size(), kHeight * (kWidth / 2 - 4));
    for (const geometry::Vec3f& direction : found) {
      EXPECT_NEAR(direction.norm(), 1.0F, 1e-5F);
      EXPECT_GT(direction.x() / direction.z() * 34.0F + 31.5F, 33.5F);
      EXPECT_GT(direction.z(), 0.0F);
    }
  }
}

}  // namespace
