// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "uav_test_tools.hpp"
#include "voxnav_simulation/tracker.hpp"

namespace {

using namespace voxnav_simulation;  // NOLINT: test
using namespace uav_test;           // NOLINT: test

TrackerLimits limits(ConstraintSet set) { return limits_of(UavConstraintsConfig{}, set); }

std::vector<Vec3> fly(Tracker* tracker, double duration_s) {
  std::vector<Vec3> out;
  for (int i = 0; i < static_cast<int>(duration_s / kStep_s); ++i) {
    tracker->step();
    out.push_back(tracker->state().position);
  }
  return out;
}

TrackedTrajectory tracked(const GeneratedTrajectory& generated) {
  TrackedTrajectory out;
  out.points = generated.samples;
  out.dt_s = generated.dt_s;
  return out;
}

TEST(Tracker, ReachesGoalsWithinLimitsAndWithoutOvershoot) {
  for (const ConstraintSet set : voxnav::base::all_values<ConstraintSet>()) {
    const char* name = voxnav::base::word_of(set);
    Tracker tracker(limits(set));
    tracker.go_to({{30, -20, 10}, 2});
    const auto path = fly(&tracker, 60);
    EXPECT_LE(usage(path, kStep_s, tracker.limits()).worst(), 1.01) << name;
    EXPECT_LT((path.back() - Vec3(30, -20, 10)).norm(), 0.01) << name;
    EXPECT_NEAR(tracker.state().heading_rad, 2, 0.01);
    double farthest = 0;
    for (const Vec3& p : path) farthest = std::max(farthest, p.dot(Vec3(30, -20, 10).normalized()));
    EXPECT_LT(farthest, Vec3(30, -20, 10).norm() + 0.05) << name;
    EXPECT_EQ(tracker.mode(), TrackerMode::kHold);
  }
}

TEST(Tracker, LimitsTheHorizontalSpeedOfEverySet) {
  UavConstraintsConfig config;
  EXPECT_EQ(limits_of(config, ConstraintSet::kFast).horizontal.speed, 8.0);
  config.max_speed_mps = 2.0;
  EXPECT_EQ(limits_of(config, ConstraintSet::kSlow).horizontal.speed, 1.0);
  EXPECT_EQ(limits_of(config, ConstraintSet::kMedium).horizontal.speed, 2.0);
  EXPECT_EQ(limits_of(config, ConstraintSet::kMedium).horizontal.acceleration, 2.0);
  EXPECT_TRUE(voxnav::base::problems_of(config).empty());
  config.max_speed_mps = 8.5;
  EXPECT_EQ(voxnav::base::problems_of(config).size(), 1U);
}

TEST(Tracker, KeepsLimitsUnderRandomCommands) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-20, 20), unit(0, 1);
    Tracker tracker(limits(static_cast<ConstraintSet>(seed % 3)));
    std::vector<Vec3> path;
    for (int k = 0; k < 60; ++k) {
      const double what = unit(random);
      if (what < 0.5) tracker.go_to({{place(random), place(random), place(random)}, place(random)});
      if (what > 0.8) tracker.brake();
      if (what >= 0.5 && what <= 0.8) {  // a trajectory that no vehicle could fly
        TrackedTrajectory wild;
        for (int i = 0; i < 20; ++i)
          wild.points.push_back({{place(random), place(random), place(random)}, place(random)});
        tracker.follow(wild);
      }
      const auto piece = fly(&tracker, 3 * unit(random));
      path.insert(path.end(), piece.begin(), piece.end());
    }
    const Usage used = usage(path, kStep_s, tracker.limits());
    EXPECT_LE(used.speed, 1.02) << "seed " << seed;
    EXPECT_LE(used.acceleration, 1.001) << "seed " << seed;
    EXPECT_LE(used.jerk, 1.001) << "seed " << seed;
  }
}

TEST(Tracker, FollowsGeneratedTrajectoriesClosely) {
  for (int seed = 0; seed < 9; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    PathRequest request;
    request.limits = limits(static_cast<ConstraintSet>(seed % 3));
    request.waypoints = random_path(&random, 8, 8);
    request.max_deviation_m = 0.2;
    const auto generated = generate_trajectory({}, request);
    Tracker tracker(request.limits);
    KinematicState start;
    start.position = request.waypoints.front().position;
    tracker.reset(start);
    tracker.follow(tracked(generated));
    for (std::size_t i = 0; i < generated.samples.size(); ++i) {
      EXPECT_LT((tracker.state().position - generated.samples[i].position).norm(), 0.05) << "seed " << seed;
      fly(&tracker, generated.dt_s);
    }
    fly(&tracker, 3);
    EXPECT_LT((tracker.state().position - request.waypoints.back().position).norm(), 0.01);
    EXPECT_FALSE(tracker.has_goal());
  }
}

TEST(Tracker, PredictionIsWhatIsFlown) {
  Tracker tracker(limits(ConstraintSet::kFast));
  tracker.go_to({{40, 5, 3}, 1});
  fly(&tracker, 2.5);
  std::vector<KinematicState> predicted;
  for (std::size_t k = 1; k <= 1562; ++k) predicted.push_back(tracker.predicted(k));
  for (const KinematicState& state : predicted) {
    tracker.step();
    ASSERT_EQ(tracker.state().position, state.position);
    ASSERT_EQ(tracker.state().velocity, state.velocity);
  }
}

TEST(Tracker, NewCommandsReplaceThePrediction) {
  Tracker tracker(limits(ConstraintSet::kMedium));
  tracker.go_to({{40, 0, 0}, 0});
  EXPECT_GT(tracker.predicted(1000).position.x(), 5);
  tracker.go_to({{-40, 0, 0}, 0});
  EXPECT_LT(tracker.predicted(1000).position.x(), -5);
}

TEST(Tracker, BrakesToAStop) {
  Tracker tracker(limits(ConstraintSet::kFast));
  tracker.go_to({{100, 0, 0}, 0});
  fly(&tracker, 5);
  const double speed = tracker.state().velocity.norm();
  const double from = tracker.state().position.x();
  ASSERT_GT(speed, 7.5);
  tracker.brake();
  fly(&tracker, 6);
  EXPECT_EQ(tracker.mode(), TrackerMode::kHold);
  EXPECT_LT(tracker.state().velocity.norm(), 0.02);
  EXPECT_LT(tracker.state().position.x() - from, 1.5 * speed * speed / (2 * 4));
}

TEST(Tracker, SlowsDownWhenLimitsAreLowered) {
  Tracker tracker(limits(ConstraintSet::kFast));
  tracker.go_to({{100, 0, 0}, 0});
  fly(&tracker, 5);
  tracker.set_limits(limits(ConstraintSet::kSlow));
  fly(&tracker, 10);
  EXPECT_LE(tracker.state().velocity.norm(), 1.01);
}

TEST(Tracker, SkipsTheBeginningAndLoops) {
  TrackedTrajectory circle;
  for (int i = 0; i <= 100; ++i)
    circle.points.push_back({{5 * std::cos(0.02 * M_PI * i), 5 * std::sin(0.02 * M_PI * i), 2}, 0});
  circle.is_loop = true;
  circle.skip_s = 5;
  Tracker tracker(limits(ConstraintSet::kMedium));
  KinematicState start;
  start.position = circle.points[25].position;
  tracker.reset(start);
  tracker.follow(circle);
  EXPECT_EQ(tracker.trajectory_index(), 25u);
  fly(&tracker, 55);  // one round takes 20 s
  EXPECT_EQ(tracker.mode(), TrackerMode::kTrajectory);
  EXPECT_LT((tracker.state().position - circle.points[0].position).norm(), 0.2);
}

}  // namespace
