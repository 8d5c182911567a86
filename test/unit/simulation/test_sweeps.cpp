// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstring>

#include "voxnav_simulation/cloud_encoder.hpp"
#include "voxnav_simulation/sweep_scheduler.hpp"

namespace voxnav_simulation {
namespace {

using voxnav::base::StampNs;
using voxnav::geometry::StampedPose;

constexpr StampNs kMs = 1'000'000;

LidarModel small_model() {
  LidarConfig config;
  config.model = BeamModel::kCustom;
  config.beam_elevations_rad = {0.0};
  config.columns = 100;
  config.mount_position_m = {0.0, 0.0, 0.5};
  return LidarModel(config, 1);
}

/// Returns the true pose of a flight along x at 1 m/s.
StampedPose truth_at(StampNs stamp_ns) {
  return {stamp_ns, voxnav::geometry::from_position_yaw({1e-9 * static_cast<double>(stamp_ns), 0, 0}, 0)};
}

std::vector<SimulatedSweep> feed(SweepScheduler* scheduler, StampNs from, StampNs to) {
  std::vector<SimulatedSweep> out;
  for (StampNs t = from; t <= to; t += 5 * kMs) {
    scheduler->add_truth(truth_at(t));
    while (auto sweep = scheduler->next()) out.push_back(*sweep);
  }
  return out;
}

TEST(SweepScheduler, TurnsStartAtWholeMultiplesAndSeeThePoseOfEachColumn) {
  const LidarModel model = small_model();
  SweepScheduler scheduler(model, false);
  const auto sweeps = feed(&scheduler, 1030 * kMs, 1500 * kMs);
  ASSERT_EQ(sweeps.size(), 4u);
  EXPECT_EQ(sweeps[0].start_ns, 1100 * kMs);
  EXPECT_EQ(sweeps[0].index, 11u);
  EXPECT_EQ(sweeps[3].index, 14u);
  for (int column = 0; column < 100; ++column) {
    EXPECT_NEAR(sweeps[0].T_W_L[column].translation().x(), 1.1 + 0.001 * column, 1e-9);
    EXPECT_NEAR(sweeps[0].T_W_L[column].translation().z(), 0.5, 1e-12);
  }
}

TEST(SweepScheduler, ReturnsATurnAsSoonAsTruePosesCoverIt) {
  const LidarModel model = small_model();
  SweepScheduler scheduler(model, false);
  EXPECT_TRUE(feed(&scheduler, 0, 95 * kMs).empty());
  scheduler.add_truth(truth_at(100 * kMs));
  EXPECT_TRUE(scheduler.next().has_value());
  EXPECT_FALSE(scheduler.next().has_value());
}

TEST(SweepScheduler, InstantaneousTurnsSeeOnePose) {
  const LidarModel model = small_model();
  SweepScheduler scheduler(model, true);
  const auto sweeps = feed(&scheduler, 100 * kMs, 100 * kMs);
  ASSERT_EQ(sweeps.size(), 1u);
  EXPECT_NEAR(sweeps[0].T_W_L[99].translation().x(), 0.1, 1e-12);
}

TEST(SweepScheduler, DoesNotInventMotionAcrossAGap) {
  const LidarModel model = small_model();
  SweepScheduler scheduler(model, false);
  feed(&scheduler, 0, 150 * kMs);
  const auto sweeps = feed(&scheduler, 520 * kMs, 800 * kMs);
  ASSERT_FALSE(sweeps.empty());
  EXPECT_EQ(sweeps[0].start_ns, 600 * kMs);
  EXPECT_EQ(scheduler.counts().truth_gaps, 1u);
}

TEST(SweepScheduler, RestartsWhenTimeIsSetBack) {
  const LidarModel model = small_model();
  SweepScheduler scheduler(model, false);
  feed(&scheduler, 5000 * kMs, 5300 * kMs);
  const auto sweeps = feed(&scheduler, 0, 200 * kMs);
  ASSERT_EQ(sweeps.size(), 2u);
  EXPECT_EQ(sweeps[0].start_ns, 0);
  EXPECT_EQ(scheduler.counts().time_jumps, 1u);
}

TEST(SweepScheduler, RefusesInvalidPoses) {
  const LidarModel model = small_model();
  SweepScheduler scheduler(model, false);
  StampedPose broken = truth_at(0);
  broken.pose.translation().x() = std::nan("");
  scheduler.add_truth(broken);
  EXPECT_FALSE(scheduler.next().has_value());
  EXPECT_EQ(scheduler.counts().poses_refused, 1u);
}

TEST(PoseHistory, InterpolatesWithinItsStampsAndReturnsNothingOutside) {
  PoseHistory history(3);
  EXPECT_FALSE(history.at(0).has_value());
  for (int i = 0; i < 5; ++i) history.add(truth_at(i * kMs));
  EXPECT_FALSE(history.at(1 * kMs).has_value()) << "forgotten";
  EXPECT_NEAR(history.at(2 * kMs + kMs / 2)->translation().x(), 0.0025, 1e-12);
  EXPECT_NEAR(history.at(4 * kMs)->translation().x(), 0.004, 1e-12);
  EXPECT_FALSE(history.at(4 * kMs + 1).has_value()) << "not yet";
}

/// Returns a scan of two rows and two columns whose only return is pixel (1, 0).
LidarScan tiny_scan() {
  LidarScan scan;
  scan.rows = scan.columns = 2;
  scan.points.assign(4, {0, 0, 0, 0});
  scan.ranges_m.assign(4, 0);
  scan.reflectivity.assign(4, 0);
  scan.labels.assign(4, kLabelNone);
  scan.column_times_ns = {0, 50'000'000};
  scan.points[2] = {1.5F, -2.0F, 0.25F, 321.0F};
  scan.ranges_m[2] = 2.5124F;
  scan.reflectivity[2] = 77.4F;
  scan.labels[2] = 0;
  return scan;
}

template <class T>
T read(const EncodedCloud& cloud, std::size_t pixel, std::uint32_t offset) {
  T value;
  std::memcpy(&value, cloud.data.data() + pixel * cloud.point_step + offset, sizeof(T));
  return value;
}

void expect_fields(const EncodedCloud& cloud, const std::vector<voxnav::cloud::CloudField>& expected) {
  ASSERT_EQ(cloud.fields.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(cloud.fields[i].name, expected[i].name);
    EXPECT_EQ(cloud.fields[i].offset, expected[i].offset) << expected[i].name;
    EXPECT_EQ(cloud.fields[i].type, expected[i].type) << expected[i].name;
  }
}

TEST(CloudEncoder, GazeboLayoutIsPackedIn29Bytes) {
  const EncodedCloud cloud = encode(tiny_scan(), DriverLayout::kGazebo);
  EXPECT_EQ(cloud.point_step, 29u);
  EXPECT_EQ(cloud.width, 2u);
  EXPECT_EQ(cloud.height, 2u);
  EXPECT_FALSE(cloud.is_dense);
  ASSERT_EQ(cloud.data.size(), 4u * 29u);
  using F = voxnav::cloud::FieldType;
  expect_fields(cloud, {{"x", 0, F::kFloat32},
                        {"y", 4, F::kFloat32},
                        {"z", 8, F::kFloat32},
                        {"intensity", 12, F::kFloat32},
                        {"ring", 16, F::kUint8},
                        {"range", 17, F::kUint32},
                        {"t", 21, F::kUint32},
                        {"reflectivity", 25, F::kUint16},
                        {"ambient", 27, F::kUint16}});
  EXPECT_EQ(read<float>(cloud, 2, 0), 1.5F);
  EXPECT_EQ(read<float>(cloud, 2, 4), -2.0F);
  EXPECT_EQ(read<float>(cloud, 2, 8), 0.25F);
  EXPECT_EQ(read<float>(cloud, 2, 12), 321.0F);
  EXPECT_EQ(read<std::uint8_t>(cloud, 2, 16), 1);
  EXPECT_EQ(read<std::uint32_t>(cloud, 2, 17), 2512u);
  EXPECT_EQ(read<std::uint32_t>(cloud, 3, 21), 0u) << "Gazebo has no times";
  EXPECT_EQ(read<std::uint16_t>(cloud, 2, 25), 77u);
  for (const std::uint32_t offset : {0u, 4u, 8u}) EXPECT_EQ(read<float>(cloud, 0, offset), 0.0F);
}

TEST(CloudEncoder, OusterLayoutIsAlignedIn48Bytes) {
  const EncodedCloud cloud = encode(tiny_scan(), DriverLayout::kOuster);
  EXPECT_EQ(cloud.point_step, 48u);
  ASSERT_EQ(cloud.data.size(), 4u * 48u);
  using F = voxnav::cloud::FieldType;
  expect_fields(cloud, {{"x", 0, F::kFloat32},
                        {"y", 4, F::kFloat32},
                        {"z", 8, F::kFloat32},
                        {"intensity", 16, F::kFloat32},
                        {"t", 20, F::kUint32},
                        {"reflectivity", 24, F::kUint16},
                        {"ring", 26, F::kUint8},
                        {"ambient", 28, F::kUint16},
                        {"range", 32, F::kUint32}});
  EXPECT_EQ(read<float>(cloud, 2, 16), 321.0F);
  EXPECT_EQ(read<std::uint32_t>(cloud, 2, 20), 0u);
  EXPECT_EQ(read<std::uint32_t>(cloud, 3, 20), 50'000'000u);
  EXPECT_EQ(read<std::uint8_t>(cloud, 2, 26), 1);
  EXPECT_EQ(read<std::uint32_t>(cloud, 2, 32), 2512u);
  for (const std::uint32_t offset : {0u, 4u, 8u}) EXPECT_EQ(read<float>(cloud, 3, offset), 0.0F);
}

}  // namespace
}  // namespace voxnav_simulation
