// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "raw_cloud.hpp"
#include "voxnav/cloud/sweep.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::Vec3f;
using test::RawCloud;

TEST(Sweep, KeepsEveryPointInOrder) {
  RawCloud c(2, 2, 29, test::gazebo_fields());
  for (std::size_t i = 0; i < 4; ++i) {
    c.set_xyz(i, static_cast<float>(i), std::nanf(""), 2.0F);
    c.set(i, "t", static_cast<std::uint32_t>(i * 25'000'000));
  }
  const cloud::Sweep sweep = cloud::read_sweep(c.view(5'000'000'000));
  ASSERT_EQ(sweep.points.size(), 4u);
  EXPECT_EQ(sweep.points[3].x(), 3.0F);
  EXPECT_EQ(sweep.time_offsets_ns[3], 75'000'000u);
  EXPECT_EQ(sweep.duration_ns, 75'000'000u);
  EXPECT_EQ(sweep.start_ns, 5'000'000'000);
  EXPECT_TRUE(sweep.open_beams.empty());
}

TEST(Sweep, CountsFromItsStartWhenTheStampIsItsEnd) {
  auto fields = test::xyzi_fields();
  fields.push_back({"time", 16, cloud::FieldType::kFloat32, 1});
  RawCloud c(1, 3, 20, fields);
  for (std::size_t i = 0; i < 3; ++i) c.set(i, "time", -0.1F + 0.05F * static_cast<float>(i));
  const cloud::Sweep sweep = cloud::read_sweep(c.view(1'000'000'000));
  EXPECT_EQ(sweep.stamp_ns, 1'000'000'000);
  EXPECT_NEAR(static_cast<double>(sweep.start_ns), 9e8, 10);
  EXPECT_EQ(sweep.time_offsets_ns[0], 0u);
  EXPECT_NEAR(sweep.time_offsets_ns[2], 1e8, 10);
}

TEST(Sweep, WithoutTimesAllPointsAreOfItsStart) {
  const cloud::Sweep sweep = cloud::read_sweep(test::xyzi_cloud(1, 5).view());
  EXPECT_EQ(sweep.time_offsets_ns, std::vector<std::uint32_t>(5, 0));
  EXPECT_EQ(sweep.duration_ns, 0u);
  EXPECT_TRUE(cloud::read_sweep(cloud::RawCloudView(cloud::CloudLayout(), nullptr, 0)).points.empty());
}

TEST(Sweep, ReadsBeamsWithoutReturnApartFromPoints) {
  auto fields = test::xyzi_fields();
  for (const char* name : {"beam_x", "beam_y", "beam_z"}) {
    fields.push_back({name, static_cast<std::uint32_t>(4 * fields.size()), cloud::FieldType::kFloat32, 1});
  }
  const float nan = std::nanf("");
  RawCloud c(1, 4, 28, fields);
  c.set_xyz(0, 1.0F, 2.0F, 3.0F);
  c.set_xyz(1, nan, nan, nan);  // an open beam
  c.set(1, "beam_z", 1.0F);
  c.set_xyz(2, nan, nan, nan);  // neither a point nor a beam, which is kept so that later stages can count it
  c.set_xyz(3, 4.0F, 5.0F, 6.0F);
  c.set(3, "beam_x", 1.0F);  // a row with coordinates is a point even if it has a direction
  const cloud::Sweep sweep = cloud::read_sweep(c.view());
  ASSERT_EQ(sweep.points.size(), 3u);
  EXPECT_EQ(sweep.points[2], Vec3f(4, 5, 6));
  ASSERT_EQ(sweep.open_beams.size(), 1u);
  EXPECT_EQ(sweep.open_beams[0], Vec3f::UnitZ());
  EXPECT_EQ(sweep.time_offsets_ns.size(), sweep.points.size());
}

TEST(Sweep, OfAFilteredCloudEqualsThatOfItsMessage) {
  cloud::FilterResult filtered;
  filtered.points = {{1, 2, 3, 50, 0}, {4, 5, 6, 60, 30'000'000}};
  filtered.sweep_start_ns = -100'000'000;
  const cloud::Sweep sweep = cloud::sweep_of(filtered, 2'000'000'000, {Vec3f::UnitY()});
  EXPECT_EQ(sweep.stamp_ns, 1'900'000'000);
  EXPECT_EQ(sweep.start_ns, 1'900'000'000);
  EXPECT_EQ(sweep.points[1], Vec3f(4, 5, 6));
  EXPECT_EQ(sweep.duration_ns, 30'000'000u);
  EXPECT_EQ(sweep.open_beams.size(), 1u);
}

}  // namespace
