// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "kernels/beam_places.hpp"
#include "occupancy/beam_image.hpp"
#include "voxnav/geometry/pose.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Vec3f;
using occupancy::BeamImage;
namespace lanes = kernels::lanes;

namespace {

constexpr float kFarthest_m = 30.0f;

std::vector<Vec3f> random_ends(unsigned seed, std::size_t n) {
  std::mt19937 rng(seed);
  std::normal_distribution<float> direction;
  std::uniform_real_distribution<float> range(1.0f, 29.0f);
  std::vector<Vec3f> out;
  while (out.size() < n) {
    const Vec3f way(direction(rng), direction(rng), direction(rng));
    out.emplace_back(way.normalized() * range(rng));
  }
  return out;
}

/// Returns the numbers of the beams that the image finds for a ball.
std::set<std::uint32_t> beams_near(const BeamImage& image, const Vec3f& center, float radius, float shortest) {
  kernels::BeamPlaces places;
  kernels::find_places(image.images(), lanes::Floats{} + center.x(), lanes::Floats{} + center.y(),
                       lanes::Floats{} + center.z(), radius, lanes::Floats{} + shortest, &places);
  std::set<std::uint32_t> out;
  const int lane = 5;  // all lanes hold the same ball
  for (int v = 0; v < places.height[lane]; ++v) {
    for (int u = 0; u < places.width[lane]; ++u) {
      const kernels::BeamPixel pixel = places.first[lane][v * places.side[lane] + u];
      if (pixel >= places.least[lane]) out.insert(static_cast<std::uint32_t>(pixel & kernels::kBeamMask));
    }
  }
  return out;
}

/// Returns whether two directions leave a cube around the sensor by the same face: the image leaves out other beams.
bool is_on_one_face(const Vec3f& a, const Vec3f& b) {
  int axis = 0;
  a.cwiseAbs().maxCoeff(&axis);
  int other = 0;
  b.cwiseAbs().maxCoeff(&other);
  return axis == other && a[axis] * b[axis] > 0.0f;
}

float distance_to_beam(const Vec3f& end, const Vec3f& p) { return end.normalized().cross(p).norm(); }

}  // namespace

TEST(BeamImage, FindsEveryBeamThroughABall) {
  const std::vector<Vec3f> ends = random_ends(1, 150);  // so few that hardly two of them share a pixel
  BeamImage image;
  image.build(ends.front().data(), ends.size(), 3, 0.5f, kFarthest_m, false);
  std::size_t found = 0, missed = 0;
  for (const Vec3f& center : random_ends(2, 4000)) {
    const float radius = 0.5f, shortest = center.norm();
    const auto beams = beams_near(image, center, radius, shortest);
    for (std::uint32_t i = 0; i < ends.size(); ++i) {
      const bool is_through = distance_to_beam(ends[i], center) < radius && is_on_one_face(ends[i], center);
      if (!is_through || ends[i].norm() < shortest || center.lpNorm<Eigen::Infinity>() < 1.6f * radius) continue;
      ++(beams.count(i) != 0 ? found : missed);
    }
  }
  EXPECT_GT(found, 100u);
  EXPECT_LE(missed, found / 20);  // a beam is missed if it shares its pixel with another
}

TEST(BeamImage, GivesNoBeamThatIsTooShortOrInAnotherDirection) {
  const std::vector<Vec3f> ends = random_ends(3, 40000);
  BeamImage image;
  image.build(ends.front().data(), ends.size(), 3, 0.5f, kFarthest_m, false);
  const float step_m = kFarthest_m / (kernels::kMaxBeamRange - 1);
  for (const Vec3f& center : random_ends(4, 500)) {
    const float radius = 0.3f, shortest = center.norm() + 0.4f;
    for (const std::uint32_t i : beams_near(image, center, radius, shortest)) {
      EXPECT_GT(ends[i].norm(), shortest - 1.01f * step_m);
      // The image gives all beams in a square of pixels around the ball, which are coarse if the ball is near.
      EXPECT_LT(ends[i].normalized().cross(center.normalized()).norm(), 0.1f + 4.0f * radius / center.norm());
    }
  }
}

TEST(BeamImage, BeamsBeyondTheLongestAreLeftOutOrKept) {
  const std::vector<Vec3f> ends{Vec3f(100.0f, 0.0f, 0.0f)};
  BeamImage image;
  image.build(ends.front().data(), 1, 3, 0.5f, kFarthest_m, false);
  EXPECT_TRUE(beams_near(image, Vec3f(10, 0, 0), 0.3f, 11.0f).empty());
  image.build(ends.front().data(), 1, 3, 0.5f, kFarthest_m, true);
  EXPECT_EQ(beams_near(image, Vec3f(10, 0, 0), 0.3f, 11.0f).size(), 1u);
}

TEST(BeamImage, GivesNoBeamForABallAroundTheSensor) {
  const std::vector<Vec3f> ends = random_ends(5, 1000);
  BeamImage image;
  image.build(ends.front().data(), ends.size(), 3, 0.5f, kFarthest_m, false);
  EXPECT_TRUE(beams_near(image, Vec3f(0.1f, 0.1f, 0.0f), 0.3f, 0.0f).empty());
  EXPECT_TRUE(beams_near(image, Vec3f(0.0f, 0.0f, 0.0f), 0.3f, 0.0f).empty());
}

TEST(BeamImage, MoreThanAMillionPointsAreTakenInPart) {
  std::vector<Vec3f> ends = random_ends(6, 1000);
  while (ends.size() < 1300000) ends.push_back(ends[ends.size() - 1000]);
  BeamImage image;
  image.build(ends.front().data(), ends.size(), 3, 0.5f, kFarthest_m, false);
  const auto beams = beams_near(image, ends[10] * 0.5f, 0.3f, 0.5f * ends[10].norm());
  ASSERT_FALSE(beams.empty());
  bool is_found = false;
  for (const std::uint32_t i : beams) {
    const float* end = image.images().ends + i * image.images().stride;
    is_found = is_found || Vec3f(end[0], end[1], end[2]) == ends[10];
  }
  EXPECT_TRUE(is_found);
}
