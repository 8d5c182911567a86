// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "hall_flight.hpp"
#include "voxnav/pipeline/mapper.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;
using pipeline::Mapper;
using pipeline::MapperConfig;
using pipeline::MapperStep;
using pipeline::SweepFate;
using test::line;
using test::Motion;
using test::stamp_of;
using test::sweep_at;

std::vector<MapperStep> all_steps(Mapper* mapper, std::vector<pipeline::Handover>* handovers = nullptr) {
  std::vector<MapperStep> out;
  while (mapper->has_next()) {
    out.push_back(mapper->next());
    for (auto& handover : mapper->close_due()) {
      if (handovers) handovers->push_back(std::move(handover));
    }
  }
  return out;
}

MapperConfig short_submaps() {
  MapperConfig config;
  config.submap.period_s = 0.5;
  config.first_submap_id = 7;
  return config;
}

TEST(Mapper, ASweepWaitsUntilPosesCoverIt) {
  Mapper mapper{MapperConfig()};
  mapper.add_pose(stamp_of(0.0), line(0.0));
  mapper.add_sweep(sweep_at(0.02));
  EXPECT_TRUE(all_steps(&mapper).empty());
  mapper.add_pose(stamp_of(0.1), line(0.1));
  EXPECT_TRUE(all_steps(&mapper).empty());  // the sweep ends after this pose
  mapper.add_pose(stamp_of(0.2), line(0.2));
  const auto steps = all_steps(&mapper);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].fate, SweepFate::kMapped);
  EXPECT_EQ(steps[0].stamp_ns, stamp_of(0.02));
  EXPECT_GT(steps[0].statistics.cells_hit, 100u);
  EXPECT_NEAR(steps[0].T_O_B.translation().x(), 1.5 * 0.07, 1e-3);  // the pose in the middle of the sweep
}

TEST(Mapper, DeskewsPointsByTheMotionWithinTheSweep) {
  Mapper mapper{MapperConfig()};
  for (int i = 0; i <= 60; ++i) mapper.add_pose(stamp_of(0.02 * i), line(0.02 * i));
  for (int i = 0; i < 10; ++i) {
    mapper.add_sweep(sweep_at(0.1 * i));
    all_steps(&mapper);
  }
  const std::vector<float> points = mapper.map().occupied_points();
  ASSERT_GT(points.size(), 300u);
  for (std::size_t i = 0; i < points.size(); i += 3) {
    const Vec3 p(points[i], points[i + 1], points[i + 2]);
    EXPECT_LT(test::hall_distance_m(p), 0.1) << p.transpose();
  }
}

TEST(Mapper, DropsSweepsThatWillNeverHaveAPoseOrWaitTooLong) {
  Mapper mapper{MapperConfig()};
  mapper.add_pose(stamp_of(5.0), line(5.0));
  mapper.add_sweep(sweep_at(1.0), std::nullopt, 0.0);
  auto steps = all_steps(&mapper);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].fate, SweepFate::kNoPose);
  EXPECT_FALSE(steps[0].reason.empty());
  mapper.add_sweep(sweep_at(6.0), std::nullopt, 10.0);
  mapper.drop_overdue(10.4, 0.5);
  EXPECT_FALSE(mapper.has_next());
  mapper.drop_overdue(10.6, 0.5);
  steps = all_steps(&mapper);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].fate, SweepFate::kNoPose);
  EXPECT_EQ(steps[0].stamp_ns, stamp_of(6.0));
}

TEST(Mapper, DropsTheOldestSweepWhenTooManyWait) {
  MapperConfig config;
  config.max_pending_scans = 2;
  Mapper mapper{config};
  for (int i = 0; i < 3; ++i) mapper.add_sweep(sweep_at(0.1 * i));
  const auto steps = all_steps(&mapper);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].fate, SweepFate::kCrowded);
  EXPECT_EQ(steps[0].stamp_ns, stamp_of(0.0));
}

TEST(Mapper, DropsSweepsThatStillWaitWhenTheInputEnds) {
  Mapper mapper{MapperConfig()};
  mapper.add_sweep(sweep_at(0.0));
  mapper.end_input();
  const auto steps = all_steps(&mapper);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].fate, SweepFate::kNoPose);
}

TEST(Mapper, ALateSweepIsDroppedAndOnlyALastingJumpBackClears) {
  Mapper mapper{MapperConfig()};
  const auto add = [&](double t) {
    mapper.add_sweep(sweep_at(t), pipeline::SweepPoses());
    std::vector<MapperStep> steps = all_steps(&mapper);
    EXPECT_EQ(steps.size(), 1u);
    return steps.at(0);
  };
  for (int i = 0; i < 3; ++i) EXPECT_EQ(add(10.0 + 0.1 * i).fate, SweepFate::kMapped);
  EXPECT_EQ(add(10.1).fate, SweepFate::kLate);
  EXPECT_EQ(add(2.0).fate, SweepFate::kLate);
  EXPECT_EQ(add(10.3).fate, SweepFate::kMapped);
  EXPECT_EQ(add(3.0).fate, SweepFate::kLate);
  EXPECT_EQ(add(3.1).fate, SweepFate::kLate);
  const MapperStep step = add(3.2);
  EXPECT_EQ(step.fate, SweepFate::kMapped);
  EXPECT_TRUE(step.map_cleared);
  EXPECT_EQ(step.handovers.size(), 1u);
}

TEST(Mapper, AJumpOfThePoseHandsOverAndClears) {
  Mapper mapper{short_submaps()};
  const auto add = [&](double t, double x) {
    pipeline::SweepPoses poses;
    poses.T_O_B.translation().x() = x;
    poses.motion.T_O_L_start = poses.motion.T_O_L_end = poses.T_O_B;
    mapper.add_sweep(sweep_at(t), poses);
    return mapper.next();
  };
  EXPECT_FALSE(add(0.0, 0.0).map_cleared);
  EXPECT_TRUE(mapper.close_due().empty());
  const MapperStep jumped = add(0.1, 50.0);
  ASSERT_EQ(jumped.handovers.size(), 1u);
  EXPECT_EQ(jumped.handovers[0].submap_id, 7u);
  EXPECT_TRUE(jumped.map_cleared);
  EXPECT_EQ(jumped.fate, SweepFate::kMapped);
  EXPECT_THROW(mapper.next(), std::logic_error);
}

TEST(Mapper, ClosesSubmapsOnTime) {
  Mapper mapper{short_submaps()};
  std::vector<pipeline::Handover> handovers;
  for (int i = 0; i < 14; ++i) {
    mapper.add_sweep(sweep_at(0.1 * i), pipeline::SweepPoses());
    all_steps(&mapper, &handovers);
  }
  ASSERT_EQ(handovers.size(), 2u);
  EXPECT_EQ(handovers[0].submap_id, 7u);
  EXPECT_EQ(handovers[1].submap_id, 8u);
  EXPECT_EQ(mapper.finish("shutdown").size(), 1u);
}

TEST(Mapper, DeskewsAndLocatesSweepsByItsOwnOdometry) {
  MapperConfig config;
  config.odometry.emplace();
  Mapper mapper{config};
  const Motion motion = [](double t) { return line(t > 0 ? t * t / (1 + t) : 0.0); };
  std::vector<MapperStep> steps;
  for (int i = 0; i < 20; ++i) {
    mapper.add_sweep(sweep_at(0.1 * i, motion));
    for (MapperStep& step : all_steps(&mapper)) steps.push_back(std::move(step));
  }
  ASSERT_EQ(steps.size(), 19u);  // the pose at the end of a sweep is known only when the next sweep is tracked
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i].fate, SweepFate::kMapped);
    const Pose truth = motion(0.1 * static_cast<double>(i) + 0.05);
    EXPECT_LT((steps[i].T_O_B.translation() - truth.translation()).norm(), 0.1) << i;
  }
  mapper.end_input();
  ASSERT_TRUE(mapper.has_next());
  EXPECT_EQ(mapper.next().fate, SweepFate::kNoPose);
}

/// Feeds samples at 200 Hz of an IMU that measures in multiples of g, which are computed by differences of the motion.
void feed_imu(const Motion& motion, double from_s, double to_s, Mapper* mapper) {
  constexpr double h = 1e-3;
  for (int i = static_cast<int>(std::lround(from_s * 200)); i < std::lround(to_s * 200); ++i) {
    const double t = i / 200.0;
    const Pose a = motion(t - h), b = motion(t + h);
    const Eigen::AngleAxisd turned(a.linear().transpose() * b.linear());
    const Vec3 acceleration = (a.translation() + b.translation() - 2 * motion(t).translation()) / (h * h);
    const Vec3 force = motion(t).linear().transpose() * (acceleration + Vec3(0, 0, 9.81)) / 9.81;
    mapper->add_imu({stamp_of(t), turned.axis() * turned.angle() / (2 * h), force});
  }
}

Pose slope(double t) {
  const double s = t > 0 ? t * t / (1 + t) : 0.0;
  return Pose(line(s) * Eigen::AngleAxisd(0.3, Vec3(0.6, -0.8, 0.0)));
}

TEST(Mapper, AnImuThatBeginsLaterLevelsTheMapFromItsBeginning) {
  MapperConfig config;
  config.odometry.emplace();
  Mapper mapper{config};
  mapper.expect_imu();
  std::vector<MapperStep> steps;
  for (int i = 0; i < 40; ++i) {
    if (i >= 4) feed_imu(slope, 0.1 * i + (i == 4 ? 0.07 : 0.005), 0.1 * i + 0.105, &mapper);
    mapper.add_sweep(sweep_at(0.1 * i, slope));
    for (MapperStep& step : all_steps(&mapper)) steps.push_back(std::move(step));
  }
  ASSERT_GE(steps.size(), 38u);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    ASSERT_EQ(steps[i].fate, SweepFate::kMapped) << steps[i].reason;
    EXPECT_EQ(steps[i].stamp_ns, stamp_of(0.1 * static_cast<double>(i)));
    const Vec3 up_B = slope(0.1 * static_cast<double>(i) + 0.05).linear().transpose() * Vec3::UnitZ();
    EXPECT_GT((steps[i].T_O_B.linear() * up_B).z(), std::cos(0.015)) << i;
  }
  EXPECT_TRUE(mapper.odometry()->is_level());
  EXPECT_TRUE(mapper.odometry_problems().empty());
}

TEST(Mapper, WithoutAnImuItReportsThatTheVerticalIsUnknown) {
  const Motion slow = [](double t) { return slope(0.4 * t); };
  for (const bool is_expected : {false, true}) {
    MapperConfig config;
    config.odometry.emplace();
    Mapper mapper{config};
    if (is_expected) mapper.expect_imu();  // but no sample comes
    std::size_t num_mapped = 0;
    for (int i = 0; i < 84; ++i) {
      mapper.add_sweep(sweep_at(0.1 * i, slow));
      num_mapped += all_steps(&mapper).size();
    }
    EXPECT_EQ(num_mapped, 83u);
    ASSERT_EQ(mapper.odometry_problems().size(), 1u);
    EXPECT_NE(mapper.odometry_problems()[0].find("nothing tells where down is"), std::string::npos);
  }
}

TEST(Mapper, OneSampleFarAheadDoesNotSilenceTheImu) {
  MapperConfig config;
  config.odometry.emplace();
  Mapper mapper{config};
  for (int i = 0; i < 20; ++i) {
    feed_imu(slope, 0.1 * i + (i == 0 ? -0.1 : 0.005), 0.1 * i + 0.05, &mapper);
    if (i == 9) mapper.add_imu({stamp_of(3600.0), Vec3::Zero(), Vec3::UnitZ()});
    mapper.add_sweep(sweep_at(0.1 * i, slope));  // the sweep waits for the samples until its end
    EXPECT_TRUE(mapper.is_waiting_for_imu());
    feed_imu(slope, 0.1 * i + 0.05, 0.1 * i + 0.105, &mapper);
    all_steps(&mapper);
  }
  EXPECT_EQ(mapper.odometry()->counters().scans_without_imu, 0u);
  ASSERT_EQ(mapper.odometry_problems().size(), 1u);
  EXPECT_NE(mapper.odometry_problems()[0].find("1 alone on another clock"), std::string::npos);
}

TEST(Mapper, OneSweepFarAheadCostsItselfAlone) {
  for (const bool has_poses : {false, true}) {
    MapperConfig config;
    if (!has_poses) config.odometry.emplace();
    Mapper mapper{config};
    std::vector<MapperStep> steps;
    for (int i = 0; i < 20; ++i) {
      if (has_poses) mapper.add_pose(stamp_of(0.1 * i), line(0.1 * i));
      cloud::Sweep sweep = sweep_at(0.1 * i);
      if (i == 9) sweep.stamp_ns = sweep.start_ns = stamp_of(3600.0);
      mapper.add_sweep(std::move(sweep));
      for (MapperStep& step : all_steps(&mapper)) steps.push_back(std::move(step));
    }
    int num_mapped = 0;
    for (const MapperStep& step : steps) {
      num_mapped += step.fate == SweepFate::kMapped;
      EXPECT_FALSE(step.map_cleared);
      if (step.fate == SweepFate::kMapped) continue;
      EXPECT_EQ(step.stamp_ns, stamp_of(3600.0));
      EXPECT_NE(step.reason.find("far ahead"), std::string::npos);
    }
    EXPECT_GE(num_mapped, 17);
  }
}

TEST(Mapper, ThinsOutOnlyWhenItIsToldOfTooMuchWork) {
  Mapper mapper{MapperConfig()};
  mapper.add_sweep(sweep_at(0.0), pipeline::SweepPoses());
  const std::size_t all = mapper.next().statistics.points;
  mapper.add_load(1.0, 0.1);
  mapper.add_sweep(sweep_at(0.1), pipeline::SweepPoses());
  EXPECT_EQ(mapper.decimation(), 2);
  EXPECT_EQ(mapper.next().statistics.points, (all + 1) / 2);
}

}  // namespace
