// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "odometry/imu_buffer.hpp"
#include "room_world.hpp"
#include "voxnav/odometry/lidar_odometry.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;
using odometry::LidarOdometry;
using odometry::LidarOdometryConfig;
using odometry::OdometryResult;
using odometry::OdometryState;
using test::RoomWorld;
using Motion = std::function<Pose(double)>;

Pose pose_at(const Vec3& position, double yaw, double roll = 0.0) {
  Pose pose = geometry::from_position_yaw(position, yaw);
  pose.linear() = pose.linear() * Eigen::AngleAxisd(roll, Vec3::UnitX()).toRotationMatrix();
  return pose;
}

/// Returns the pose on a smooth flight with turns, which starts at the identity, at rest and without acceleration.
Pose flight(double time) {
  const double t = time > 0 ? time * time / (1 + time) : 0.0;
  return pose_at(Vec3(2.0 * (1 - std::cos(0.8 * t)), 1.2 * (1 - std::cos(0.6 * t)), 0.4 * (1 - std::cos(t))),
                 1.5 * (1 - std::cos(0.9 * t)), 0.15 * (1 - std::cos(1.7 * t)));
}

base::StampNs stamp_of(double t) { return base::from_seconds(1000.0 + t); }

/// Feeds angular velocity and specific force of a motion, which are computed by differences.
/// @param g_mps2  the magnitude of gravity that the IMU measures
void feed_imu(const Motion& motion, double from_s, double to_s, LidarOdometry* o, double g_mps2 = 9.81) {
  constexpr double h = 1e-4;
  for (int i = static_cast<int>(std::lround(from_s * 200)); i < std::lround(to_s * 200); ++i) {
    const double t = i / 200.0;
    const Pose a = motion(t - h), b = motion(t + h);
    const Vec3 gyro = odometry::log_so3(Eigen::Quaterniond(a.linear().transpose() * b.linear())) / (2 * h);
    const Vec3 acceleration = (a.translation() + b.translation() - 2 * motion(t).translation()) / (h * h);
    const Vec3 force = motion(t).linear().transpose() * (acceleration + Vec3(0, 0, 9.81));
    o->add_imu({stamp_of(t), gyro, g_mps2 / 9.81 * force});
  }
}

OdometryResult add_scan(const RoomWorld& world, const Motion& motion, int index, LidarOdometry* o,
                        bool with_times = true) {
  const double t = index * 0.1;
  const test::RoomSweep sweep = test::sweep_of(world, motion, t, 0.01, static_cast<std::uint32_t>(index));
  return o->add_cloud(stamp_of(t), sweep.points_L, with_times ? sweep.times_s : std::vector<float>());
}

double position_error(const OdometryResult& r, const Pose& truth) {
  return (r.T_O_B.translation() - truth.translation()).norm();
}
double angle_error(const OdometryResult& r, const Pose& truth) {
  return Eigen::AngleAxisd(r.T_O_B.linear().transpose() * truth.linear()).angle();
}

/// Returns a scan that does not match the map.
std::vector<geometry::Vec3f> garbage(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> in(-40, 40);
  std::vector<geometry::Vec3f> out(20000);
  for (auto& p : out) p = {in(random), in(random), in(random)};
  return out;
}

TEST(LidarOdometry, FollowsAFlightWithImu) {
  LidarOdometry o{LidarOdometryConfig()};
  double worst_m = 0, worst_rad = 0;
  for (int i = 0; i < 60; ++i) {
    feed_imu(flight, i * 0.1 - 0.05, i * 0.1 + 0.05, &o);
    feed_imu(flight, i * 0.1 + 0.05, i * 0.1 + 0.1, &o);
    const OdometryResult r = add_scan(RoomWorld::hall(), flight, i, &o);
    worst_m = std::max(worst_m, position_error(r, flight(i * 0.1)));
    worst_rad = std::max(worst_rad, angle_error(r, flight(i * 0.1)));
    if (i == 0) continue;
    EXPECT_EQ(r.quality.state, OdometryState::kTracking) << i << ": " << r.quality.reason;
  }
  EXPECT_LT(worst_m, 0.06);
  EXPECT_LT(worst_rad, 0.01);
  EXPECT_EQ(o.counters().scans_without_imu, 0u);
}

TEST(LidarOdometry, FollowsAFlightWithoutImu) {
  LidarOdometry o{LidarOdometryConfig()};
  OdometryResult r;
  for (int i = 0; i < 60; ++i) r = add_scan(RoomWorld::hall(), flight, i, &o);
  EXPECT_EQ(r.quality.state, OdometryState::kTracking);
  EXPECT_LT(position_error(r, flight(5.9)), 0.1);
  EXPECT_LT(angle_error(r, flight(5.9)), 0.02);
}

TEST(LidarOdometry, DeskewingIsWhatMakesFastTurnsAccurate) {
  const Motion spin = [](double t) { return pose_at(Vec3(1.0 * t, 0, 0), 1.5 * t * t / (1 + t)); };
  double error[2];
  for (bool with_times : {false, true}) {
    LidarOdometry o{LidarOdometryConfig()};
    OdometryResult r;
    for (int i = 0; i < 25; ++i) {
      feed_imu(spin, i * 0.1, i * 0.1 + 0.1, &o);
      r = add_scan(RoomWorld::hall(), spin, i, &o, with_times);
    }
    error[with_times] = position_error(r, spin(2.4)) + 5.0 * angle_error(r, spin(2.4));
  }
  EXPECT_LT(error[1], 0.08);
  EXPECT_GT(error[0], 2.0 * error[1]);
}

TEST(LidarOdometry, StartsUprightFromTheImu) {
  LidarOdometry o{LidarOdometryConfig()};
  const Motion tilted = [](double) { return pose_at(Vec3::Zero(), 0.0, 0.2); };
  feed_imu(tilted, -0.5, 0.1, &o);
  const OdometryResult r = add_scan(RoomWorld::hall(), tilted, 0, &o);
  EXPECT_LT(angle_error(r, tilted(0)), 1e-3);
}

TEST(LidarOdometry, StartsUprightWhateverTheUnitOfTheImuAndHoweverItIsMounted) {
  for (const double g_mps2 : {1.0, 1000.0, 9.6}) {
    for (const double roll : {0.3, 1.6, 3.1}) {
      LidarOdometry o{LidarOdometryConfig()};
      const Motion tilted = [&](double) { return Pose(Eigen::AngleAxisd(roll, Vec3::UnitX())); };
      EXPECT_FALSE(o.is_level());
      feed_imu(tilted, -0.5, 0.1, &o, g_mps2);
      const OdometryResult r = add_scan(RoomWorld::hall(), tilted, 0, &o);
      EXPECT_LT(angle_error(r, tilted(0)), 1e-3);
      EXPECT_TRUE(o.is_level());
      EXPECT_FALSE(o.level());
    }
  }
}

TEST(LidarOdometry, AnImuThatBeginsLaterTurnsTheFrameUpright) {
  const Motion tilted = [](double t) { return Pose(flight(t) * Eigen::AngleAxisd(0.25, Vec3(0.6, 0.8, 0.0))); };
  const auto up_error = [&](const OdometryResult& r, double t) {
    const Vec3 up_B = tilted(t).linear().transpose() * Vec3::UnitZ();
    return std::acos(std::min(1.0, (r.T_O_B.linear() * up_B).z()));
  };
  LidarOdometry o{LidarOdometryConfig()};
  std::optional<Pose> turn;
  OdometryResult r;
  for (int i = 0; i < 60; ++i) {
    if (i >= 5) feed_imu(tilted, i * 0.1 + (i == 5 ? 0.03 : 0.0), i * 0.1 + 0.1, &o);
    r = add_scan(RoomWorld::hall(), tilted, i, &o);
    if (i == 4) {
      EXPECT_GT(up_error(r, 0.4), 0.2);
    }
    if (turn) continue;
    turn = o.level();
    if (!turn) continue;
    EXPECT_LT(((*turn * r.T_O_B).matrix() - o.last().T_O_B.matrix()).norm(), 1e-9);
    EXPECT_LT(up_error(o.last(), i * 0.1), 0.01);
  }
  ASSERT_TRUE(turn);
  EXPECT_TRUE(o.is_level());
  EXPECT_EQ(r.quality.state, OdometryState::kTracking);
  EXPECT_LT(up_error(r, 5.9), 0.015);
}

TEST(LidarOdometry, MeasuresTheTiltOfItsFrameAgainstGravity) {
  // The vehicle accelerates during the first samples, which looks like a slope.
  const Motion starts = [](double t) {
    const double ramp = std::min(std::max(t, 0.0), 1.0);
    return pose_at(Vec3(ramp * ramp + 2.0 * std::max(t - 1.0, 0.0), 0, 0), 0.0);
  };
  LidarOdometry o{LidarOdometryConfig()};
  for (int i = 0; i < 60; ++i) {
    feed_imu(starts, i * 0.1 + (i == 0 ? 0.01 : 0.0), i * 0.1 + 0.1, &o);
    add_scan(RoomWorld::hall(), starts, i, &o);
  }
  ASSERT_TRUE(o.tilt_rad());
  EXPECT_NEAR(*o.tilt_rad(), std::atan2(2.0, 9.81), 0.02);
}

TEST(LidarOdometry, ReportsPosesOfTheBodyNotOfTheSensor) {
  const Pose T_B_L = pose_at(Vec3(0.1, 0.0, 0.3), 1.0, 0.1);
  LidarOdometry o(LidarOdometryConfig(), T_B_L);
  OdometryResult r;
  for (int i = 0; i < 30; ++i) {
    feed_imu(flight, i * 0.1 - (i == 0 ? 0.05 : 0.0), i * 0.1 + 0.1, &o);
    r = add_scan(
        RoomWorld::hall(), [&](double t) { return Pose(flight(t) * T_B_L); }, i, &o);
  }
  EXPECT_LT(position_error(r, flight(2.9)), 0.06);
  EXPECT_LT(angle_error(r, flight(2.9)), 0.01);
}

TEST(LidarOdometry, CoastsThroughGarbageWithoutAJumpAndRecovers) {
  LidarOdometry o{LidarOdometryConfig()};
  const Motion line = [](double t) { return pose_at(Vec3(0.5 * t, 0, 0), 0); };
  OdometryResult before;
  for (int i = 0; i < 15; ++i) before = add_scan(RoomWorld::hall(), line, i, &o);
  for (int i = 15; i < 25; ++i) {
    const OdometryResult r = o.add_cloud(stamp_of(i * 0.1), garbage(static_cast<std::uint32_t>(i)));
    EXPECT_EQ(r.quality.state, OdometryState::kCoasting);
    EXPECT_FALSE(r.quality.reason.empty());
    EXPECT_LT((r.T_O_B.translation() - before.T_O_B.translation()).norm(), 0.08);
    EXPECT_GT(r.covariance(0, 0), before.covariance(0, 0));
    before = r;
  }
  for (int i = 25; i < 30; ++i) before = add_scan(RoomWorld::hall(), line, i, &o);
  EXPECT_EQ(before.quality.state, OdometryState::kTracking) << before.quality.reason;
  EXPECT_LT(position_error(before, line(2.9)), 0.05);
  EXPECT_LT(before.covariance(0, 0), 0.01);
}

/// Returns a long street with pillars at irregular intervals on both sides.
RoomWorld street() {
  RoomWorld w;
  w.room = {Vec3(-60, -12, -2), Vec3(400, 14, 30)};
  double x = -50;
  while (x < 120) {
    w.boxes.push_back({Vec3(x, 6, -2), Vec3(x + 1.5, 8, 8)});
    w.boxes.push_back({Vec3(x + 4, -9, -2), Vec3(x + 5, -6, 6)});
    x += 9 + 4 * std::sin(x);
  }
  return w;
}

TEST(LidarOdometry, AFewPoorScansDoNotLoseAFastVehicle) {
  constexpr int kFirstPoor = 25, kNumScans = 40;
  // The vehicle accelerates to 14 m/s within two seconds and goes straight on.
  const Motion drive = [](double t) { return pose_at(Vec3(t < 2 ? 3.5 * t * t : 14.0 * (t - 1.0), 0, 0), 0); };
  for (const int num_poor : {1, 3}) {
    LidarOdometry o{LidarOdometryConfig()};
    OdometryResult r;
    for (int i = 0; i < kNumScans; ++i) {
      const bool is_poor = i >= kFirstPoor && i < kFirstPoor + num_poor;
      if (is_poor) {
        r = o.add_cloud(stamp_of(i * 0.1), garbage(static_cast<std::uint32_t>(i)));
      } else {
        r = add_scan(street(), drive, i, &o);
      }
      if (i == 0) continue;
      EXPECT_EQ(r.quality.state, is_poor ? OdometryState::kCoasting : OdometryState::kTracking)
          << i << ": " << r.quality.reason;
      if (i >= kFirstPoor) EXPECT_NEAR(r.velocity_B.x(), 14.0, 2.0) << num_poor << ", " << i;
    }
    EXPECT_NEAR(r.velocity_B.x(), 14.0, 0.3) << num_poor;
    EXPECT_LT(position_error(r, drive(0.1 * (kNumScans - 1))), 0.5) << num_poor;
  }
}

TEST(LidarOdometry, EmptyScansCoastToo) {
  LidarOdometry o{LidarOdometryConfig()};
  const Motion still = [](double) { return Pose::Identity(); };
  for (int i = 0; i < 5; ++i) add_scan(RoomWorld::hall(), still, i, &o);
  const OdometryResult r = o.add_cloud(stamp_of(0.5), {});
  EXPECT_EQ(r.quality.state, OdometryState::kCoasting);
  EXPECT_LT(r.T_O_B.translation().norm(), 0.02);
}

TEST(LidarOdometry, BeginsANewMapAtTheCoastedPoseWhenTheOldOneIsLost) {
  LidarOdometryConfig config;
  config.restart_after_s = 1.0;
  LidarOdometry o(config);
  const Motion still = [](double) { return Pose::Identity(); };
  const Motion elsewhere = [](double) { return pose_at(Vec3(300, 3, 0.2), 0.3); };
  RoomWorld other = RoomWorld::hall();
  for (auto* box : {&other.room}) {
    box->min += Vec3(300, 0, 0);
    box->max += Vec3(320, 15, 4);
  }
  for (int i = 0; i < 10; ++i) add_scan(RoomWorld::hall(), still, i, &o);
  OdometryResult r;
  double worst_step = 0;
  for (int i = 10; i < 30; ++i) {
    const Vec3 before = o.last().T_O_B.translation();
    r = add_scan(other, elsewhere, i, &o);
    worst_step = std::max(worst_step, (r.T_O_B.translation() - before).norm());
  }
  EXPECT_EQ(o.counters().map_restarts, 1u);
  EXPECT_EQ(r.quality.state, OdometryState::kTracking) << r.quality.reason;
  EXPECT_LT(worst_step, 0.3);
  EXPECT_GT(std::sqrt(r.covariance(0, 0)), 0.3);  // the uncertainty from the gap remains
}

TEST(LidarOdometry, ACorridorIsFlaggedAndNotDriftedAlong) {
  LidarOdometry o{LidarOdometryConfig()};
  const Motion sideways = [](double t) { return pose_at(Vec3(0, 0.3 * std::sin(t), 0), 0.1 * std::sin(t)); };
  OdometryResult r;
  for (int i = 0; i < 40; ++i) {
    r = add_scan(RoomWorld::corridor(), sideways, i, &o);
    EXPECT_EQ(r.quality.is_degenerate, i > 0) << i;
  }
  EXPECT_EQ(r.quality.state, OdometryState::kTracking);
  EXPECT_LT(std::abs(r.T_O_B.translation().x()), 0.15);
  EXPECT_NEAR(r.T_O_B.translation().y(), sideways(3.9).translation().y(), 0.05);
  EXPECT_GT(r.covariance(0, 0), 10 * r.covariance(1, 1));
}

TEST(LidarOdometry, RefusesOldStampsAndSurvivesAClockThatFallsBack) {
  LidarOdometry o{LidarOdometryConfig()};
  const Motion still = [](double) { return Pose::Identity(); };
  for (int i = 0; i < 5; ++i) add_scan(RoomWorld::hall(), still, i, &o);
  const auto scan = test::sweep_of(RoomWorld::hall(), still, 0, 0.01, 77);
  EXPECT_FALSE(o.add_cloud(stamp_of(0.2), scan.points_L).is_new);
  EXPECT_FALSE(o.add_cloud(stamp_of(0.4), scan.points_L).is_new);
  EXPECT_FALSE(o.add_cloud(stamp_of(3600.0), scan.points_L).is_new);  // a single cloud on another clock
  EXPECT_FALSE(o.add_cloud(stamp_of(-500.0), scan.points_L).is_new);
  EXPECT_FALSE(o.add_cloud(stamp_of(-499.9), scan.points_L).is_new);
  const OdometryResult r = o.add_cloud(stamp_of(-499.8), scan.points_L);  // the third cloud confirms the new clock
  EXPECT_TRUE(r.is_new);
  EXPECT_LT(r.T_O_B.translation().norm(), 0.03);
  EXPECT_EQ(o.counters().clock_jumps, 1u);
  EXPECT_EQ(o.counters().clouds_refused, 5u);
}

TEST(LidarOdometry, CountsPointsThatAreNotFinite) {
  LidarOdometry o{LidarOdometryConfig()};
  auto scan = test::sweep_of(
      RoomWorld::hall(), [](double) { return Pose::Identity(); }, 0, 0.01, 1);
  for (std::size_t i = 0; i < 10; ++i) scan.points_L[i].x() = std::nanf("");
  scan.times_s[20] = std::nanf("");
  o.add_cloud(stamp_of(0), scan.points_L, scan.times_s);
  EXPECT_EQ(o.counters().points_refused, 11u);
  EXPECT_THROW(o.add_cloud(stamp_of(1), scan.points_L, {0.1F}), std::invalid_argument);
}

TEST(LidarOdometry, IsDeterministicAndForgetsOnReset) {
  OdometryResult results[2];
  LidarOdometry o{LidarOdometryConfig()};
  for (OdometryResult& r : results) {
    for (int i = 0; i < 8; ++i) r = add_scan(RoomWorld::hall(), flight, i, &o);
    o.reset();
  }
  EXPECT_TRUE(results[0].T_O_B.matrix() == results[1].T_O_B.matrix());
  EXPECT_EQ(o.num_map_points(), 0u);
}

}  // namespace
