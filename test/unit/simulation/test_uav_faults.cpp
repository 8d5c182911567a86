// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "voxnav_simulation/uav.hpp"

namespace {

using namespace voxnav_simulation;  // NOLINT: test

UavSetup undrifting() {
  UavSetup setup;
  setup.drift.bound_m = 0;
  return setup;
}

UavSetup with_all_faults() {
  UavSetup setup;
  UavFaults& f = setup.faults;
  f.tracking.is_enabled = f.wind.is_enabled = f.state_noise.is_enabled = f.refusals.is_enabled = true;
  f.avoidance.is_enabled = f.bumper.is_enabled = f.resets.is_enabled = true;
  f.avoidance.interval_s = f.resets.interval_s = 10;
  return setup;
}

void fly(Uav* uav, double duration_s) {
  for (int i = 0; i < static_cast<int>(std::lround(duration_s / kStep_s)); ++i) uav->step();
}

void take_off(Uav* uav) {
  ASSERT_TRUE(uav->take_off().success);
  for (int i = 0; i < 4000 && uav->phase() != FlightPhase::kFlying; ++i) uav->step();
  ASSERT_EQ(uav->phase(), FlightPhase::kFlying);
}

Vec3 place(const Uav& uav) { return uav.truth().pose.translation(); }

TEST(TrackingResponse, FollowsAStepOfTheReferenceLikeTheControllerItIs) {
  const TrackingConfig config;
  TrackingResponse response(config, false);
  KinematicState reference;
  response.reset(reference);
  reference.position = Vec3(1, 0, 0);
  double first_s = 0, half_s = 0, peak_m = 0;
  for (int i = 1; i <= 2000; ++i) {
    response.step(reference, Vec3::Zero(), kStep_s);
    const double x = response.position().x(), t = i * kStep_s;
    if (first_s == 0 && x > 0) first_s = t;
    if (half_s == 0 && x > 0.5) half_s = t;
    peak_m = std::max(peak_m, x);
  }
  EXPECT_NEAR(first_s, config.delay_s + kStep_s, 1e-9);
  // A double integrator behind a lag of 0.2 s with kp = 6 and kv = 4 passes half of a step after about 0.5 s.
  EXPECT_GT(half_s, 0.4);
  EXPECT_LT(half_s, 0.7);
  EXPECT_GT(peak_m, 1.05);
  EXPECT_LT(peak_m, 1.4);
  EXPECT_NEAR(response.position().x(), 1.0, 0.02);
}

TEST(TrackingResponse, RefusesGainsThatSwing) {
  TrackingConfig config;
  EXPECT_TRUE(voxnav::base::problems_of(config).empty());
  config.delay_s = 0.5;
  EXPECT_EQ(voxnav::base::problems_of(config).size(), 1U);
}

/// The largest distance between the tracker and the true place along a flight of 40 m, and how far the vehicle went
/// past the goal.
struct Lag {
  double largest_m = 0;
  double overshoot_m = 0;
};
Lag lag_of(const UavSetup& setup) {
  Uav uav(setup, 1);
  take_off(&uav);
  const double y = place(uav).y(), z = place(uav).z();
  EXPECT_TRUE(uav.go_to({{40, y, z}, 0}).success);
  Lag out;
  for (int i = 0; i < 6000; ++i) {
    uav.step();
    out.largest_m = std::max(out.largest_m, (uav.tracker().state().position - place(uav)).norm());
    out.overshoot_m = std::max(out.overshoot_m, place(uav).x() - 40);
  }
  EXPECT_NEAR(place(uav).x(), 40, 0.05);
  return out;
}

TEST(UavFaults, TrackingLagsBehindAndOvershoots) {
  UavSetup setup = undrifting();
  EXPECT_LT(lag_of(setup).largest_m, 1e-9);
  setup.faults.tracking.is_enabled = true;
  const Lag lag = lag_of(setup);
  RecordProperty("lag_mm", static_cast<int>(1000 * lag.largest_m));
  RecordProperty("overshoot_mm", static_cast<int>(1000 * lag.overshoot_m));
  EXPECT_GT(lag.largest_m, 0.1);
  EXPECT_LT(lag.largest_m, 0.5);
  EXPECT_GT(lag.overshoot_m, 0.005);
  EXPECT_LT(lag.overshoot_m, 0.3);
}

TEST(Wind, HasItsMeanSpreadAndTime) {
  WindConfig config;
  config.is_enabled = true;
  Wind wind(config, 3);
  constexpr int kCount = 400000;
  const int lag = static_cast<int>(std::lround(config.gust_time_s / 0.05));
  std::vector<Vec3> gusts;
  Vec3 mean = Vec3::Zero();
  for (int i = 0; i < kCount; ++i) {
    wind.step(0.05);
    gusts.push_back(wind.velocity());
    mean += wind.velocity() / kCount;
  }
  Vec3 squares = Vec3::Zero(), products = Vec3::Zero();
  for (int i = lag; i < kCount; ++i) {
    const Vec3 now = gusts[static_cast<std::size_t>(i)] - mean, then = gusts[static_cast<std::size_t>(i - lag)] - mean;
    squares += now.cwiseAbs2() / (kCount - lag);
    products += now.cwiseProduct(then) / (kCount - lag);
  }
  EXPECT_NEAR(mean.x(), 2.0, 0.15);
  EXPECT_NEAR(mean.y(), 1.0, 0.15);
  EXPECT_NEAR(mean.z(), 0.0, 0.1);
  EXPECT_NEAR(std::sqrt(squares.x()), 1.5, 0.1);
  EXPECT_NEAR(std::sqrt(squares.z()), 0.8, 0.05);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(products[i] / squares[i], std::exp(-1.0), 0.05);
}

TEST(UavFaults, WindPushesAHoveringVehicle) {
  UavSetup setup = undrifting();
  setup.faults.wind.is_enabled = true;
  for (const bool lags : {false, true}) {
    setup.faults.tracking.is_enabled = lags;
    Uav uav(setup, 5);
    take_off(&uav);
    fly(&uav, 60);
    const Vec3 held = uav.tracker().state().position;
    double largest_m = 0;
    Vec3 mean = Vec3::Zero();
    for (int i = 0; i < 12000; ++i) {
      uav.step();
      largest_m = std::max(largest_m, (place(uav) - held).norm());
      mean += (place(uav) - held) / 12000;
    }
    RecordProperty(lags ? "pushed_with_lag_mm" : "pushed_mm", static_cast<int>(1000 * largest_m));
    EXPECT_GT(largest_m, 0.03);
    EXPECT_LT(largest_m, 0.5);
    EXPECT_LT(mean.norm(), 0.1) << "the controller learns steady wind";
  }
}

TEST(UavFaults, NoiseIsInTheEstimateAlone) {
  UavSetup setup = undrifting();
  Uav exact(setup, 2);
  setup.faults.state_noise.is_enabled = true;
  Uav noisy(setup, 2);
  take_off(&exact), take_off(&noisy);
  double position = 0, velocity = 0;
  constexpr int kCount = 100000;
  for (int i = 0; i < kCount; ++i) {
    exact.step(), noisy.step();
    ASSERT_EQ(place(exact), place(noisy));
    position += (noisy.estimate().pose.translation() - place(noisy)).squaredNorm() / (3 * kCount);
    velocity += (noisy.estimate().velocity - noisy.truth().velocity).squaredNorm() / (3 * kCount);
  }
  EXPECT_NEAR(std::sqrt(position), setup.faults.state_noise.position_m, 0.003);
  EXPECT_NEAR(std::sqrt(velocity), setup.faults.state_noise.velocity_mps, 0.01);
}

TEST(UavFaults, ReferencesAreRefusedWhileBraking) {
  UavSetup setup = undrifting();
  for (const bool refuses : {false, true}) {
    setup.faults.refusals.is_enabled = refuses;
    Uav uav(setup, 1);
    take_off(&uav);
    ASSERT_TRUE(uav.go_to({{40, 0, 2}, 0}).success);
    fly(&uav, 5);
    ASSERT_TRUE(uav.hover().success);
    fly(&uav, 0.5);
    const CommandResult result = uav.go_to({{10, 0, 2}, 0});
    EXPECT_EQ(result.success, !refuses);
    if (!refuses) continue;
    EXPECT_NE(result.message.find("callbacks are disabled"), std::string::npos);
    TrackedTrajectory trajectory;
    trajectory.points = {{{0, 0, 2}, 0}, {{1, 0, 2}, 0}};
    EXPECT_FALSE(uav.set_trajectory(trajectory).success);
    EXPECT_TRUE(uav.hover().success);
    fly(&uav, 5);
    EXPECT_TRUE(uav.go_to({{10, 0, 2}, 0}).success);
  }
}

TEST(UavFaults, ClimbsOverAnotherVehicleAndComesBack) {
  UavSetup setup = undrifting();
  setup.faults.avoidance.is_enabled = true;
  setup.faults.avoidance.interval_s = 5;
  setup.faults.avoidance.duration_s = 8;
  Uav uav(setup, 4);
  take_off(&uav);
  const double z = place(uav).z();
  ASSERT_TRUE(uav.go_to({{400, 0, z}, 0}).success);
  double begin_m = 0, highest_m = 0, speed_mps = 0, after_mps = 0;
  int num_climbs = 0;
  bool was_avoiding = false;
  for (int i = 0; i < 12000; ++i) {
    uav.step();
    if (uav.is_avoiding() && !was_avoiding) {
      ++num_climbs;
      begin_m = place(uav).z();
    }
    was_avoiding = uav.is_avoiding();
    const double up_m = place(uav).z() - begin_m, flown_mps = uav.truth().velocity.head<2>().norm();
    if (was_avoiding) highest_m = std::max(highest_m, up_m);
    if (was_avoiding && up_m > 2.9) speed_mps = std::max(speed_mps, flown_mps);
    if (!was_avoiding) after_mps = std::max(after_mps, flown_mps);
  }
  EXPECT_GE(num_climbs, 2);
  EXPECT_NEAR(highest_m, 3.0, 0.1);
  EXPECT_LT(speed_mps, 1.1) << "a quarter of 4 m/s is left up there";
  EXPECT_GT(after_mps, 3.5);
  EXPECT_TRUE(uav.hover().success) << "nothing is disabled by a climb";
}

TEST(UavFaults, ClimbsOnlyWhereThereIsRoom) {
  UavSetup setup = undrifting();
  setup.faults.avoidance.is_enabled = true;
  setup.faults.avoidance.interval_s = 1;
  SensedWorld roof;
  roof.clearance = [](const Vec3& p, double max_m, voxnav::base::StampNs) {
    return std::min(max_m, std::max(0.0, 5.0 - p.z()));
  };
  Uav uav(setup, 4, roof);
  take_off(&uav);
  for (int i = 0; i < 12000; ++i) {
    uav.step();
    ASSERT_FALSE(uav.is_avoiding());
  }
}

/// A wall at x = 10 that is 4 m wide, so that there is a way around it.
SensedWorld wall() {
  SensedWorld out;
  out.range = [](const Vec3& from, const Vec3& direction, double max_m,
                 voxnav::base::StampNs) -> std::optional<double> {
    if (direction.x() * (10.0 - from.x()) <= 0) return std::nullopt;
    const double range_m = (10.0 - from.x()) / direction.x();
    if (range_m > max_m || std::abs(from.y() + range_m * direction.y()) > 2) return std::nullopt;
    return range_m;
  };
  return out;
}

TEST(UavFaults, BumperRepelsFromAWallAndDisablesCallbacks) {
  UavSetup setup = undrifting();
  setup.faults.bumper.is_enabled = true;
  setup.faults.bumper.is_derived_from_dynamics = false;
  setup.limits = limits_of(UavConstraintsConfig{}, ConstraintSet::kSlow);
  Uav uav(setup, 1, wall());
  take_off(&uav);
  ASSERT_TRUE(uav.go_to({{9.5, 0, 2}, 0}).success);
  fly(&uav, 5);
  EXPECT_FALSE(uav.is_repelled());
  bool was_repelled = false;
  for (int i = 0; i < 4000; ++i) {
    uav.step();
    EXPECT_LT(place(uav).x(), 9.4);
    if (uav.is_repelled() && !was_repelled) {
      EXPECT_NEAR(place(uav).x(), 10 - 1.2, 0.1);
      EXPECT_NE(uav.go_to({{0, 0, 2}, 0}).message.find("bumper"), std::string::npos);
      was_repelled = true;
    }
  }
  EXPECT_TRUE(was_repelled);
  EXPECT_FALSE(uav.is_repelled());
  EXPECT_NEAR(place(uav).x(), 10 - 1.4, 0.1);
  EXPECT_TRUE(uav.go_to({{0, 0, 2}, 0}).success);
}

TEST(UavFaults, BumperDistanceFollowsFromTheLimits) {
  BumperConfig config;
  const Bumper bumper(config);
  const TrackerLimits limits = limits_of(UavConstraintsConfig{}, ConstraintSet::kMedium);
  double asked_m = 0;
  const auto nothing = [&](const Vec3&, double max_m) {
    asked_m = std::max(asked_m, max_m);
    return std::optional<double>();
  };
  EXPECT_FALSE(bumper.push(nothing, 0, limits).has_value());
  EXPECT_NEAR(asked_m, 1.2 + 1.5 * 4.0, 1e-9);  // 4 m/s and 2 m/s^2 stop within 4 m
}

TEST(UavFaults, AnEstimatorResetMovesTheFrameAndNotTheVehicle) {
  UavSetup setup = undrifting();
  setup.faults.resets.is_enabled = true;
  setup.faults.resets.interval_s = 5;
  for (const bool lags : {false, true}) {
    setup.faults.tracking.is_enabled = lags;
    Uav uav(setup, 6);
    take_off(&uav);
    TrackedTrajectory trajectory;
    for (int i = 0; i < 200; ++i) trajectory.points.push_back({{0.5 * i, 0, 2}, 0});
    ASSERT_TRUE(uav.set_trajectory(trajectory).success);
    std::uint32_t iteration = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec3 true_before = place(uav), before = uav.estimate().pose.translation(),
                 goal = uav.tracker().goal().position;
      uav.step();
      const Vec3 moved = uav.estimate().pose.translation() - before;
      EXPECT_LT((place(uav) - true_before).norm(), 0.03);
      if (uav.estimator_iteration() == iteration) {
        EXPECT_LT(moved.norm(), 0.03);
      } else {
        iteration = uav.estimator_iteration();
        EXPECT_NEAR(moved.norm(), setup.faults.resets.jump_m, 0.03);
        EXPECT_NEAR((uav.tracker().goal().position - goal).norm(), setup.faults.resets.jump_m, 1e-9);
      }
    }
    EXPECT_GE(iteration, 2U);
    EXPECT_LT((uav.estimate().pose.translation() - place(uav) - uav.drift()).norm(), 1e-9);
    fly(&uav, 30);  // the trajectory has moved along: it ends where it would have ended
    EXPECT_LT((place(uav) - Vec3(99.5, 0, 2)).norm(), 0.1);
  }
}

TEST(UavFaults, SameSeedSameFlightWithAllFaults) {
  Uav a(with_all_faults(), 7), b(with_all_faults(), 7), c(with_all_faults(), 8);
  for (Uav* uav : {&a, &b, &c}) {
    take_off(uav);
    uav->go_to({{100, 0, 3}, 0});
    fly(uav, 40);
  }
  EXPECT_EQ(a.truth().pose.matrix(), b.truth().pose.matrix());
  EXPECT_EQ(a.estimate().pose.matrix(), b.estimate().pose.matrix());
  EXPECT_EQ(a.imu().accel, b.imu().accel);
  EXPECT_NE(a.truth().pose.matrix(), c.truth().pose.matrix());
}

TEST(UavFaults, LandsWithAllFaults) {
  Uav uav(with_all_faults(), 9);
  take_off(&uav);
  ASSERT_TRUE(uav.land().success);
  fly(&uav, 20);
  EXPECT_EQ(uav.phase(), FlightPhase::kIdle);
  EXPECT_NEAR(*uav.height_m(), 0.25, 0.05);
}

}  // namespace
