// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "hall_flight.hpp"
#include "voxnav/pipeline/mapper.hpp"

// Several sensors in one map: each is mapped with its own mount and limits, and none waits for another.

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;
using pipeline::Mapper;
using pipeline::MapperConfig;
using pipeline::MapperStep;
using pipeline::SweepFate;
using test::line;
using test::stamp_of;

Pose tilted() { return Pose(Eigen::Translation3d(-0.2, 0.1, 0.3) * Eigen::AngleAxisd(0.6, Vec3::UnitY())); }

cloud::Sweep sweep_of(std::size_t sensor, double t) {
  const Pose T_B_L = sensor == 0 ? Pose::Identity() : tilted();
  cloud::Sweep out = test::sweep_at(t, [&](double s) { return Pose(line(s) * T_B_L); });
  out.sensor = sensor;
  return out;
}

MapperConfig config_of(std::size_t num_sensors) {
  MapperConfig config;
  config.sensors.resize(num_sensors);
  return config;
}

/// A mapper of two sensors that knows their mounts and the poses of the first second.
struct TwoSensors {
  explicit TwoSensors(const MapperConfig& config = config_of(2)) : mapper(config) {
    mapper.set_mount(1, tilted());
    for (int i = 0; i <= 60; ++i) mapper.add_pose(stamp_of(0.02 * i), line(0.02 * i));
  }
  std::vector<MapperStep> add(cloud::Sweep sweep) {
    mapper.add_sweep(std::move(sweep));
    return take();
  }
  std::vector<MapperStep> take() {
    std::vector<MapperStep> out;
    while (mapper.has_next()) {
      out.push_back(mapper.next());
      mapper.close_due();
    }
    return out;
  }
  Mapper mapper;
};

int num_with(const std::vector<MapperStep>& steps, SweepFate fate) {
  int count = 0;
  for (const MapperStep& step : steps) count += step.fate == fate;
  return count;
}

TEST(MapperSensors, EachIsPlacedByItsOwnMount) {
  TwoSensors both;
  for (int i = 0; i < 10; ++i) {
    for (const std::size_t sensor : {0u, 1u}) {
      const auto steps = both.add(sweep_of(sensor, 0.1 * i));
      ASSERT_EQ(steps.size(), 1u);
      EXPECT_EQ(steps[0].fate, SweepFate::kMapped) << steps[0].reason;
      EXPECT_EQ(steps[0].sensor, sensor);
      EXPECT_EQ(steps[0].leads, sensor == 0);
    }
  }
  const std::vector<float> points = both.mapper.map().occupied_points();
  ASSERT_GT(points.size(), 300u);
  for (std::size_t i = 0; i < points.size(); i += 3)
    EXPECT_LT(test::hall_distance_m(Vec3(points[i], points[i + 1], points[i + 2])), 0.15);
}

TEST(MapperSensors, ASensorWithoutMountCostsTheOtherNothing) {
  Mapper mapper{config_of(2)};
  Mapper alone{config_of(1)};
  std::vector<MapperStep> steps;
  for (int i = 0; i <= 60; ++i) {
    for (Mapper* each : {&mapper, &alone}) each->add_pose(stamp_of(0.02 * i), line(0.02 * i));
  }
  for (int i = 0; i < 10; ++i) {
    mapper.add_sweep(sweep_of(1, 0.1 * i));  // comes first, and waits
    mapper.add_sweep(sweep_of(0, 0.1 * i));
    bool is_mapped = false;
    while (mapper.has_next()) {
      const MapperStep step = mapper.next();
      is_mapped = is_mapped || step.sensor == 0;
      if (step.sensor == 1) {
        EXPECT_EQ(step.fate, SweepFate::kCrowded);
      }
    }
    EXPECT_TRUE(is_mapped) << "the first sensor waits for the second";
    alone.add_sweep(sweep_of(0, 0.1 * i));
    alone.next();
  }
  EXPECT_EQ(mapper.map().to_bytes(), alone.map().to_bytes());
}

TEST(MapperSensors, AStuckClockCostsItsSensorAlone) {
  TwoSensors both;
  int num_late = 0;
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(num_with(both.add(sweep_of(0, 0.1 * i)), SweepFate::kMapped), 1);
    num_late += num_with(both.add(sweep_of(1, 0.2)), SweepFate::kLate);
  }
  EXPECT_EQ(num_late, 9);
}

TEST(MapperSensors, AClockThatLagsNeitherClearsTheMapNorMisplacesItsSensor) {
  TwoSensors both;
  for (int i = 0; i < 40; ++i) both.mapper.add_pose(stamp_of(1.2 + 0.1 * i), line(1.2 + 0.1 * i));
  std::vector<MapperStep> behind;
  for (int i = 0; i < 20; ++i) {
    const auto steps = both.add(sweep_of(0, 3.0 + 0.1 * i));
    EXPECT_EQ(num_with(steps, SweepFate::kMapped), 1);
    EXPECT_FALSE(steps[0].map_cleared);
    for (MapperStep& step : both.add(sweep_of(1, 0.1 * i))) behind.push_back(std::move(step));
  }
  ASSERT_EQ(behind.size(), 20u);
  for (const MapperStep& step : behind) {
    EXPECT_EQ(step.fate, SweepFate::kLate);
    EXPECT_NE(step.reason.find("behind those of the other sensors"), std::string::npos) << step.reason;
  }
}

TEST(MapperSensors, PosesOfASubmapFollowOneSensorUntilItDies) {
  MapperConfig config = config_of(2);
  config.first_submap_id = 1;
  TwoSensors both(config);
  for (int i = 0; i < 80; ++i) both.mapper.add_pose(stamp_of(1.2 + 0.1 * i), line(1.2 + 0.1 * i));
  for (int i = 0; i < 80; ++i) {
    if (i < 40) both.add(sweep_of(0, 0.1 * i));
    both.add(sweep_of(1, 0.1 * i + 0.03));
  }
  const auto handovers = both.mapper.finish("shutdown");
  ASSERT_EQ(handovers.size(), 1u);
  const auto& poses = handovers[0].poses;
  ASSERT_EQ(poses.size(), 71u);  // 40 of the first, and 31 of the second from a second after
  for (std::size_t i = 1; i < poses.size(); ++i) EXPECT_GT(poses[i].stamp_ns, poses[i - 1].stamp_ns);
  EXPECT_EQ(poses[39].stamp_ns, stamp_of(3.9));
  EXPECT_EQ(poses[40].stamp_ns, stamp_of(4.93));
}

TEST(MapperSensors, EachHasItsOwnRange) {
  MapperConfig config = config_of(2);
  config.map.no_return_range_m = 5.0;
  config.sensors[1].max_range_m = 4.0;
  config.sensors[1].no_return_range_m = 0.0;
  TwoSensors both(config);
  cloud::Sweep near;
  near.sensor = 1;
  near.stamp_ns = near.start_ns = stamp_of(0.1);
  near.points = {geometry::Vec3f(3.0F, 0.0F, 0.0F), geometry::Vec3f(0.0F, 6.0F, 0.0F)};
  near.time_offsets_ns = {0, 0};
  near.open_beams = {geometry::Vec3f(0.0F, -1.0F, 0.0F)};
  both.mapper.set_mount(1, Pose::Identity());
  const auto steps = both.add(near);
  ASSERT_EQ(num_with(steps, SweepFate::kMapped), 1);
  EXPECT_EQ(steps[0].statistics.far, 1u);
  const Pose T_O_L = line(0.1);
  const occupancy::LocalMap& map = both.mapper.map();
  const auto evidence = [&](const Vec3& p_L) { return map.log_odds(T_O_L * p_L).value_or(0.0); };
  EXPECT_GT(evidence(Vec3(3.0, 0, 0)), 0.0);
  EXPECT_LT(evidence(Vec3(0, 3.5, 0)), 0.0);   // cleared up to its range
  EXPECT_EQ(evidence(Vec3(0, 5.0, 0)), 0.0);   // and no farther
  EXPECT_EQ(evidence(Vec3(0, -3.0, 0)), 0.0);  // it says nothing where nothing returned
  near.sensor = 0;
  near.stamp_ns = near.start_ns = stamp_of(0.2);
  ASSERT_EQ(num_with(both.add(near), SweepFate::kMapped), 1);
  EXPECT_GT(map.log_odds(line(0.2) * Vec3(0, 6.0, 0)).value_or(0.0), 0.0);
  EXPECT_LT(map.log_odds(line(0.2) * Vec3(0, -3.0, 0)).value_or(0.0), 0.0);
}

TEST(MapperSensors, RefusesWhatItHasNot) {
  EXPECT_THROW(Mapper{config_of(0)}, base::ConfigError);
  Mapper mapper{config_of(2)};
  EXPECT_THROW(mapper.set_mount(2, Pose::Identity()), std::invalid_argument);
  cloud::Sweep sweep = sweep_of(0, 0.0);
  sweep.sensor = 2;
  EXPECT_THROW(mapper.add_sweep(sweep), std::invalid_argument);
}

TEST(MapperSensors, OwnOdometryFollowsTheFirstAndPlacesTheOthers) {
  MapperConfig config = config_of(2);
  config.odometry.emplace();
  Mapper mapper{config};
  mapper.set_mount(1, tilted());
  int num_mapped[2] = {0, 0};
  for (int i = 0; i < 20; ++i) {
    for (const std::size_t sensor : {0u, 1u}) mapper.add_sweep(sweep_of(sensor, 0.1 * i));
    while (mapper.has_next()) {
      const MapperStep step = mapper.next();
      if (step.fate != SweepFate::kMapped) continue;
      ++num_mapped[step.sensor];
      EXPECT_LT((step.T_O_B.translation() - line(base::to_seconds(step.stamp_ns) - 999.95).translation()).norm(), 0.2);
    }
  }
  EXPECT_GE(num_mapped[0], 18);
  EXPECT_GE(num_mapped[1], 18);
}

}  // namespace
