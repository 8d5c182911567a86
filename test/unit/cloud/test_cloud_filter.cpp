// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "raw_cloud.hpp"
#include "voxnav/cloud/cloud_filter.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using cloud::CloudFilter;
using cloud::CloudFilterConfig;
using cloud::FieldType;
using cloud::FilterResult;
using test::RawCloud;

/// For clouds whose points are no image of a surface: each of them would be an outlier.
CloudFilterConfig without_outlier_removal() {
  CloudFilterConfig config;
  config.remove_outliers = false;
  return config;
}

FilterResult filtered(const CloudFilterConfig& config, const RawCloud& c, base::StampNs stamp_ns = 0) {
  return CloudFilter(config).apply(c.view(stamp_ns));
}

TEST(CloudFilter, SortsEachPointByItsReason) {
  RawCloud c = test::xyzi_cloud(1, 7);
  c.set_xyz(0, std::nanf(""), 1, 1);
  c.set_xyz(1, 0, 0, 0);
  c.set_xyz(2, 0.5F, 0.1F, 0);
  c.set_xyz(3, 0.9F, 0, 0);
  c.set_xyz(4, 200, 0, 0);
  c.set(5, "intensity", 3.0F);
  CloudFilterConfig config;
  config.min_range_m = 1.0;
  config.ghost_intensity = 10;
  const FilterResult r = filtered(config, c);
  EXPECT_EQ(r.counts.nan, 1u);
  EXPECT_EQ(r.counts.zero, 1u);
  EXPECT_EQ(r.counts.body, 1u);
  EXPECT_EQ(r.counts.near, 1u);
  EXPECT_EQ(r.counts.far, 1u);
  EXPECT_EQ(r.counts.ghost, 1u);
  ASSERT_EQ(r.counts.kept, 1u);
  EXPECT_EQ(r.points[0].x, 8.0F);
  EXPECT_EQ(r.far[0].x, 200.0F);
  EXPECT_EQ(r.ghosts[0].x, 7.0F);
}

TEST(CloudFilter, InfinityIsNotAFarPoint) {
  RawCloud c = test::xyzi_cloud(1, 2);
  c.set_xyz(0, std::numeric_limits<float>::infinity(), 0, 0);
  c.set_xyz(1, 3e38F, 3e38F, 0);  // finite, although the square of its range is not
  const FilterResult r = filtered({}, c);
  EXPECT_EQ(r.counts.nan, 1u);
  EXPECT_EQ(r.counts.far, 1u);
}

TEST(CloudFilter, AllNanAndEmptyCloudsGiveNothing) {
  RawCloud c = test::xyzi_cloud(8, 8);
  for (std::size_t i = 0; i < 64; ++i) c.set_xyz(i, std::nanf(""), std::nanf(""), std::nanf(""));
  CloudFilter filter{without_outlier_removal()};
  FilterResult r;
  filter.apply(c.view(), &r);
  EXPECT_EQ(r.counts.nan, 64u);
  EXPECT_TRUE(r.points.empty());
  filter.apply(test::xyzi_cloud(4, 4).view(), &r);
  EXPECT_EQ(r.points.size(), 16u);
  filter.apply(RawCloud(1, 0, 16, test::xyzi_fields()).view(), &r);
  EXPECT_EQ(r.counts.total, 0u);
  EXPECT_TRUE(r.points.empty());
}

TEST(CloudFilter, RemovesTheBodyBoxAndNothingBesideIt) {
  CloudFilterConfig config;
  config.body_radius_m = 0;
  config.min_range_m = 0;
  config.use_body_box = true;
  config.body_box_min_m = {-1, -0.2, -3};
  config.body_box_max_m = {1, 0.2, -0.5};
  RawCloud c = test::xyzi_cloud(1, 4);
  c.set_xyz(0, 0.9F, 0.1F, -2.9F);
  c.set_xyz(1, 1.1F, 0.1F, -2.9F);
  c.set_xyz(2, 0.9F, 0.3F, -2.9F);
  c.set_xyz(3, 0.9F, 0.1F, -0.4F);
  const FilterResult r = filtered(config, c);
  EXPECT_EQ(r.counts.body, 1u);
  EXPECT_EQ(r.counts.kept, 3u);
}

TEST(CloudFilter, KeepsWeakReturnsBeyondTheGhostRange) {
  CloudFilterConfig config;
  config.ghost_intensity = 50;
  config.ghost_range_m = 10;
  RawCloud c = test::xyzi_cloud(1, 3);
  c.set_xyz(0, 9.9F, 0, 0);
  c.set_xyz(1, 10.1F, 0, 0);
  c.set(0, "intensity", 49.0F);
  c.set(1, "intensity", 49.0F);
  const FilterResult r = filtered(config, c);
  EXPECT_EQ(r.counts.ghost, 1u);
  EXPECT_EQ(r.counts.kept, 2u);
}

// Sensors and simulators without intensity report 0 for every point; without an exception all of them would be removed.
TEST(CloudFilter, ACloudWithoutIntensityLosesNothingToTheGhostFilter) {
  CloudFilterConfig config = without_outlier_removal();
  config.ghost_intensity = 50;
  RawCloud c = test::xyzi_cloud(2, 10);
  for (std::size_t i = 0; i < 20; ++i) c.set(i, "intensity", 0.0F);
  const FilterResult r = filtered(config, c);
  EXPECT_TRUE(r.is_ghost_filter_suspended);
  EXPECT_EQ(r.counts.kept, 20u);
  EXPECT_EQ(r.counts.ghost, 0u);
}

TEST(CloudFilter, DecimatesEverySize) {
  for (const auto& [height, width, rows, columns] : std::vector<std::array<std::uint32_t, 4>>{
           {128, 1024, 2, 2}, {7, 13, 2, 3}, {16, 5, 3, 7}, {2, 1, 4, 4}, {5, 100, 1, 99}}) {
    CloudFilterConfig config = without_outlier_removal();
    config.row_decimation = static_cast<int>(rows);
    config.column_decimation = static_cast<int>(columns);
    const FilterResult r = filtered(config, test::xyzi_cloud(height, width));
    const std::uint64_t expected = std::uint64_t{(height + rows - 1) / rows} * ((width + columns - 1) / columns);
    EXPECT_EQ(r.counts.kept, expected) << height << " x " << width;
    EXPECT_EQ(r.counts.decimated, std::uint64_t{height} * width - expected);
  }
}

TEST(CloudFilter, UnorganisedCloudsHaveTheirOwnDecimation) {
  CloudFilterConfig config;
  config.row_decimation = config.column_decimation = 8;
  config.unorganised_decimation = 3;
  EXPECT_EQ(filtered(config, test::xyzi_cloud(1, 100)).counts.kept, 34u);
}

TEST(CloudFilter, CyclingDecimationUsesEveryPixelInTurn) {
  CloudFilterConfig config = without_outlier_removal();
  config.row_decimation = 2;
  config.column_decimation = 3;
  config.cycle_decimation = true;
  RawCloud c = test::xyzi_cloud(5, 7);
  for (std::size_t i = 0; i < 35; ++i) c.set(i, "intensity", static_cast<float>(i));
  CloudFilter filter(config);
  std::vector<int> seen(35, 0);
  for (int scan = 0; scan < 6; ++scan) {
    for (const auto& p : filter.apply(c.view()).points) ++seen[static_cast<std::size_t>(p.intensity)];
  }
  for (std::size_t i = 0; i < 35; ++i) EXPECT_EQ(seen[i], 1) << i;
}

TEST(CloudFilter, OutlierRemovalDropsLonePointsAndKeepsPoles) {
  RawCloud c = test::xyzi_cloud(32, 32);
  for (std::size_t i = 0; i < 1024; ++i) c.set_xyz(i, 0, 0, 0);
  for (std::size_t r = 0; r < 32; ++r)
    c.set_xyz(r * 32 + 10, 5.0F, 0.0F, 0.1F * static_cast<float>(r));  // a pole that is one pixel wide
  c.set_xyz(3 * 32 + 20, 3.0F, 1.0F, 0.0F);                            // a drop of rain
  CloudFilterConfig config;
  config.outlier_min_neighbours = 1;
  const FilterResult r = filtered(config, c);
  EXPECT_EQ(r.counts.outlier, 1u);
  ASSERT_EQ(r.points.size(), 32u);
  for (const auto& p : r.points) EXPECT_EQ(p.x, 5.0F);
  // By default the two ends of the pole, which have one neighbour each, go with the drop.
  EXPECT_EQ(filtered({}, c).counts.outlier, 3u);
}

/// A wall of 64 points at 5 m, in the first rows of a cloud of 16 x 32.
RawCloud wall_cloud() {
  RawCloud c = test::xyzi_cloud(16, 32);
  for (std::size_t i = 0; i < 512; ++i) c.set_xyz(i, 0, 0, 0);
  for (std::size_t i = 0; i < 64; ++i) {
    const std::size_t row = i / 32;
    c.set_xyz(i, 5.0F, 0.1F * static_cast<float>(i % 32), 0.1F * static_cast<float>(row));
  }
  return c;
}

TEST(CloudFilter, FarLonePointsAreNoOutliers) {
  RawCloud c = wall_cloud();
  c.set_xyz(8 * 32 + 5, 7.9F, 0.0F, 0.0F);
  c.set_xyz(12 * 32 + 20, 8.1F, 0.0F, 0.0F);
  const FilterResult r = filtered({}, c);
  EXPECT_EQ(r.counts.outlier, 1u);
  ASSERT_EQ(r.points.size(), 65u);
  EXPECT_EQ(r.points.back().x, 8.1F);
}

TEST(CloudFilter, ASensorWhoseBeamsAreFarApartLosesNothing) {
  RawCloud c = wall_cloud();
  for (std::size_t i = 0; i < 64; ++i) {
    const std::size_t row = i / 32;
    c.set_xyz(i, 5.0F, static_cast<float>(i % 32), static_cast<float>(row));
  }
  EXPECT_EQ(filtered({}, c).counts.outlier, 0u);
  EXPECT_EQ(filtered({}, c).counts.kept, 64u);
  EXPECT_TRUE(filtered({}, c).is_outlier_filter_suspended);
}

TEST(CloudFilter, RainIsRemovedThoughThereIsLittleElse) {
  CloudFilter filter{CloudFilterConfig()};
  FilterResult result;
  const RawCloud wall = wall_cloud();
  filter.apply(wall.view(), &result);
  EXPECT_EQ(result.counts.outlier, 0u);
  RawCloud rain = test::xyzi_cloud(16, 32);
  for (std::size_t i = 0; i < 512; ++i) rain.set_xyz(i, 0, 0, 0);
  // Fourteen drops, none of them within two columns and a row of another.
  for (std::size_t i = 0; i < 512; i += 37) rain.set_xyz(i, 3.0F, 0.01F * static_cast<float>(i), 0.0F);
  filter.apply(rain.view(), &result);
  EXPECT_FALSE(result.is_outlier_filter_suspended);
  EXPECT_EQ(result.counts.outlier, 14u);
  EXPECT_TRUE(result.points.empty());
}

TEST(CloudFilter, ReadsPackedGazeboAndOusterClouds) {
  for (bool gazebo : {true, false}) {
    RawCloud c(2, 2, gazebo ? 29 : 48, gazebo ? test::gazebo_fields() : test::ouster_fields());
    c.set_xyz(3, 4.0F, -5.0F, 6.0F);
    c.set(3, "intensity", 77.0F);
    c.set(3, "t", std::uint32_t{99000000});
    const FilterResult r = filtered({}, c);
    ASSERT_EQ(r.points.size(), 1u);
    EXPECT_EQ(r.counts.zero, 3u);
    EXPECT_EQ(r.points[0].y, -5.0F);
    EXPECT_EQ(r.points[0].intensity, 77.0F);
    EXPECT_EQ(r.points[0].time_offset_ns, 99000000u);
  }
}

RawCloud velodyne_cloud(FieldType time_type, const char* time_name, const std::vector<double>& times) {
  auto fields = test::xyzi_fields();
  fields[3] = {"intensity", 12, FieldType::kUint8, 1};
  fields.push_back({time_name, 13, time_type, 1});
  RawCloud c(1, static_cast<std::uint32_t>(times.size()), 22, fields);
  for (std::size_t i = 0; i < times.size(); ++i) {
    c.set_xyz(i, 5, 5, 5);
    c.set(i, "intensity", std::uint8_t{200});
    if (time_type == FieldType::kFloat32) {
      c.set(i, time_name, static_cast<float>(times[i]));
    } else {
      c.set(i, time_name, times[i]);
    }
  }
  return c;
}

TEST(CloudFilter, TurnsSecondsBeforeTheStampIntoTimesAfterTheSweepStart) {
  const FilterResult r = filtered({}, velodyne_cloud(FieldType::kFloat32, "time", {-0.1, -0.05, 0.0}));
  ASSERT_EQ(r.points.size(), 3u);
  EXPECT_EQ(r.points[0].intensity, 200.0F);
  EXPECT_NEAR(static_cast<double>(r.sweep_start_ns), -1e8, 10);
  EXPECT_EQ(r.points[0].time_offset_ns, 0u);
  EXPECT_NEAR(r.points[1].time_offset_ns, 5e7, 10);
  EXPECT_NEAR(r.points[2].time_offset_ns, 1e8, 10);
}

TEST(CloudFilter, ReadsAbsoluteTimesAndRefusesForeignClocks) {
  const double start = 1700000000.25;
  const RawCloud c = velodyne_cloud(FieldType::kFloat64, "timestamp", {start, start + 0.0625, 12.0, std::nan("")});
  const FilterResult r = filtered({}, c, base::from_seconds(start));
  ASSERT_EQ(r.points.size(), 4u);
  EXPECT_EQ(r.sweep_start_ns, 0);
  EXPECT_NEAR(r.points[1].time_offset_ns, 62500000.0, 300.0);
  EXPECT_EQ(r.num_bad_times, 2u);
}

TEST(CloudFilter, RefusesAConfigurationThatKeepsNothing) {
  CloudFilterConfig config;
  config.min_range_m = 5;
  config.max_range_m = 4;
  EXPECT_THROW(CloudFilter{config}, base::ConfigError);
  config = CloudFilterConfig();
  config.use_body_box = true;
  config.body_box_min_m = config.body_box_max_m;
  EXPECT_THROW(CloudFilter{config}, base::ConfigError);
}

}  // namespace
