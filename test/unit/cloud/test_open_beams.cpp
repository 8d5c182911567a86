// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "raw_cloud.hpp"
#include "voxnav/cloud/open_beams.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using cloud::OpenBeams;
using cloud::OpenBeamsConfig;
using geometry::Vec3f;
using test::RawCloud;

constexpr int kRows = 32, kColumns = 256;

Vec3f beam(int row, int column, double turn) {
  const double elevation = 0.7 - 1.4 * row / (kRows - 1);
  const double azimuth = 3.0 + turn * 2.0 * M_PI * column / kColumns + 0.03 * (row % 4);
  return Vec3f(static_cast<float>(std::cos(elevation) * std::cos(azimuth)),
               static_cast<float>(std::cos(elevation) * std::sin(azimuth)), static_cast<float>(std::sin(elevation)));
}

/// Returns a scan with the given range(row, column) in metres, where 0 stands for no return.
RawCloud scan(const std::function<double(int, int)>& range, double turn = -1.0) {
  RawCloud out(kRows, kColumns, 16, test::xyzi_fields());
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const Vec3f p = beam(r, c, turn) * static_cast<float>(range(r, c));
      const int point = r * kColumns + c;
      out.set_xyz(static_cast<std::size_t>(point), p.x(), p.y(), p.z());
    }
  }
  return out;
}

const OpenBeamsConfig kEvery{true, 1, 2, 1, 1};  // every open beam with margins of one row and two columns

std::vector<Vec3f> learnt(OpenBeams* beams, const RawCloud& cloud) {
  for (int i = 0; i < 7; ++i) beams->find(cloud.view());
  return beams->find(cloud.view());
}

struct Nearest {
  int column;
  double error_rad;
};

/// Returns the beam of the rows up to `last_row` that is nearest to a direction.
Nearest nearest_beam(const Vec3f& direction, int last_row, double turn) {
  Nearest best{0, 10.0};
  for (int r = 0; r <= last_row; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const double error_rad = std::acos(std::min(direction.dot(beam(r, c, turn)), 1.0F));
      if (error_rad < best.error_rad) best = {c, error_rad};
    }
  }
  return best;
}

}  // namespace

TEST(OpenBeams, SkyWithoutAnyReturnIsFoundInItsTrueDirection) {
  for (const double turn : {-1.0, 1.0}) {
    const RawCloud meadow = scan([](int r, int) { return r < 14 ? 0.0 : 8.0; }, turn);
    OpenBeams beams(kEvery);
    const std::vector<Vec3f> open = learnt(&beams, meadow);
    ASSERT_EQ(open.size(), 13u * kColumns);  // row 13 is within the margin of rows with returns
    for (std::size_t i = 0; i < open.size(); i += 97) EXPECT_LT(nearest_beam(open[i], 12, turn).error_rad, 0.01);
  }
}

TEST(OpenBeams, MissingReturnsAmongReturnsAreNotSky) {
  const RawCloud dropouts = scan([](int r, int c) { return (r + c) % 3 == 0 ? 0.0 : 12.0; });
  OpenBeams beams(kEvery);
  EXPECT_TRUE(learnt(&beams, dropouts).empty());
}

TEST(OpenBeams, NothingIsOpenNextToAThinPole) {
  const RawCloud pole = scan([](int r, int c) { return r > 20 || c == 100 || c == 255 ? 5.0 : 0.0; });
  OpenBeams beams(kEvery);
  const std::vector<Vec3f> open = learnt(&beams, pole);
  EXPECT_EQ(open.size(), 20u * (kColumns - 10));
  for (const Vec3f& direction : open) {
    const int column = nearest_beam(direction, 19, -1.0).column;
    EXPECT_GT(std::abs(column - 100), 2);
    EXPECT_TRUE(column > 1 && column < 253) << column;  // columns 0 and 1 are within the margin of the pole at 255
  }
}

TEST(OpenBeams, FindsNothingBeforeItHasLearntTheSensor) {
  OpenBeams beams(kEvery);
  EXPECT_TRUE(beams.find(scan([](int, int) { return 0.0; }).view()).empty());
  EXPECT_TRUE(beams.find(test::xyzi_cloud(1, 500).view()).empty());
  const RawCloud random = scan([](int r, int c) { return 3.0 + (r * 31 + c * 17) % 7; });
  RawCloud shuffled = random;
  for (std::size_t i = 0; i < shuffled.layout.num_points(); ++i) {
    std::copy_n(random.bytes.begin() + static_cast<std::ptrdiff_t>(16 * ((i * 7919) % random.layout.num_points())), 16,
                shuffled.bytes.begin() + static_cast<std::ptrdiff_t>(16 * i));
  }
  EXPECT_TRUE(learnt(&beams, shuffled).empty());  // the azimuths of shuffled columns follow no rule
  const RawCloud empty = scan([](int, int) { return 0.0; });
  EXPECT_TRUE(beams.find(empty.view()).empty());
}

TEST(OpenBeams, ValuesThatAreNotFiniteAreNoReturns) {
  RawCloud meadow = scan([](int r, int) { return r < 14 ? 0.0 : 8.0; });
  OpenBeams beams(kEvery);
  const std::size_t count = learnt(&beams, meadow).size();
  for (std::size_t i = 0; i < std::size_t{14} * kColumns; i += 5) meadow.set_xyz(i, NAN, INFINITY, 1.0F);
  EXPECT_EQ(beams.find(meadow.view()).size(), count);
}
