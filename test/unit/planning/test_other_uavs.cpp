// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "planning/other_uavs.hpp"
#include "planning/sightings.hpp"
#include "steps.hpp"

using namespace voxnav;  // NOLINT: test
using base::from_seconds;
using geometry::Vec3;
using planning::OtherUav;
using planning::OtherUavTrack;
using planning::place_at;
using planning::radius_at;

namespace {

/// A UAV that comes towards the origin along x at 2 m/s from 20 m, as announced at 10 s, and rests after 4 s.
OtherUav comer() {
  OtherUav out;
  out.name = "uav7";
  out.stamp_ns = out.seen_ns = from_seconds(10.0);
  out.step_s = 0.5;
  for (int i = 0; i <= 8; ++i) out.places.emplace_back(20.0 - 1.0 * i, 0.0, 2.0);
  out.radius_m = 1.0;
  out.growth_mps = 0.5;
  out.late_growth_mps = 1.0;
  out.max_growth_m = 4.0;
  out.horizon_s = 8.0;
  return out;
}

planning::TimedLine towards(double speed_mps) {
  planning::TimedLine out;
  for (const double x : test::steps(0.0, 20.0 + 0.1 * speed_mps, 0.2 * speed_mps)) {
    out.points.emplace_back(x, 0.0, 2.0);
    out.times_s.push_back(x / speed_mps);
  }
  return out;
}

TEST(OtherUavs, AreWhereTheyAnnouncedAndTheirRoomGrows) {
  const OtherUav other = comer();
  EXPECT_TRUE(place_at(other, from_seconds(9.0)).isApprox(Vec3(20, 0, 2)));
  EXPECT_TRUE(place_at(other, from_seconds(11.25)).isApprox(Vec3(17.5, 0, 2)));
  EXPECT_TRUE(place_at(other, from_seconds(30.0)).isApprox(Vec3(12, 0, 2)));
  EXPECT_DOUBLE_EQ(radius_at(other, from_seconds(9.0)), 1.0);
  EXPECT_DOUBLE_EQ(radius_at(other, from_seconds(12.0)), 2.0);
  EXPECT_DOUBLE_EQ(radius_at(other, from_seconds(15.0)), 1.0 + 2.5 + 1.0);  // a second after its last place
  EXPECT_DOUBLE_EQ(radius_at(other, from_seconds(60.0)), 5.0);
}

TEST(OtherUavs, AFlightMeetsThemWhereBothAreAtTheSameTime) {
  planning::Sightings sightings;
  sightings.stamp_ns = from_seconds(10.0);
  EXPECT_TRUE(sightings.has_nothing_to_meet());
  sightings.others = std::make_shared<const std::vector<OtherUav>>(1, comer());
  EXPECT_FALSE(sightings.has_nothing_to_meet());
  const auto meeting = planning::first_meeting(sightings, towards(2.0), from_seconds(10.0), 0.7);
  ASSERT_TRUE(meeting);
  EXPECT_EQ(meeting->name, "uav7");
  // They are 20 m apart, close in by 4 m/s, and touch at 1.7 m plus the growth of 0.5 m/s.
  EXPECT_NEAR(meeting->after_s, (20.0 - 1.7) / 4.5, 0.1);
  EXPECT_NEAR(meeting->arc_m, 2.0 * meeting->after_s, 0.01);
  // Seen from a sweep of two seconds later the same meeting is at the same time.
  sightings.stamp_ns = from_seconds(12.0);
  const auto again = planning::first_meeting(sightings, towards(2.0), from_seconds(10.0), 0.7);
  ASSERT_TRUE(again);
  EXPECT_NEAR(again->after_s, meeting->after_s, 0.06);
  OtherUav near = comer();
  near.horizon_s = 2.0;
  sightings.others = std::make_shared<const std::vector<OtherUav>>(1, near);
  EXPECT_FALSE(planning::first_meeting(sightings, towards(2.0), from_seconds(10.0), 0.7)) << "beyond its horizon";
}

TEST(OtherUavs, AVehicleAtRestIsMetByThoseThatComeToIt) {
  planning::Sightings sightings;
  sightings.stamp_ns = from_seconds(10.0);
  sightings.others = std::make_shared<const std::vector<OtherUav>>(1, comer());
  const planning::TimedLine rest{{Vec3(14, 0, 2)}, {0.0}};
  const auto meeting = planning::first_meeting(sightings, rest, from_seconds(10.0), 0.7);
  ASSERT_TRUE(meeting);
  EXPECT_EQ(meeting->arc_m, 0.0);
}

/// A search keeps clear of the places where both may be at the same time, not of all places where the other one is.
TEST(OtherUavs, ATrackForbidsWhereTheVehicleMayMeetIt) {
  const OtherUavTrack track(comer(), from_seconds(10.0), 1.0);
  const planning::Arrival arrival{from_seconds(10.0), Vec3(0, 0, 2), 4.0};
  EXPECT_FALSE(track.may_meet(arrival, Vec3(0, 0, 2))) << "it is far when the vehicle leaves its place";
  EXPECT_TRUE(track.may_meet(arrival, Vec3(13, 0, 2)));
  EXPECT_FALSE(track.may_meet(arrival, Vec3(13, 8, 2)));
  const planning::Arrival late{from_seconds(10.0), Vec3(-80, 0, 2), 4.0};
  EXPECT_FALSE(track.may_meet(late, Vec3(19, 0, 2))) << "it has left long before the vehicle comes";
}

TEST(OtherUavs, PartsOfATrackAreThoseThatReachABox) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> along(-5.0, 25.0), across(-8.0, 8.0);
  const OtherUavTrack track(comer(), from_seconds(10.0), 1.0);
  const planning::Arrival arrival{from_seconds(10.0), Vec3(2, 0, 2), 3.0};
  int met = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 place(along(random), across(random), across(random));
    const geometry::Aabb box{place - Vec3::Constant(0.5), place + Vec3::Constant(0.7)};
    EXPECT_EQ(track.within(box).may_meet(arrival, place), track.may_meet(arrival, place));
    if (!track.may_meet(arrival, place)) continue;
    ++met;
    EXPECT_TRUE(track.box().contains(place));
  }
  EXPECT_GT(met, 50);
}

TEST(OtherUavs, BadOnesAreRefused) {
  EXPECT_NO_THROW(planning::require_valid(comer()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  OtherUav empty = comer(), lost = comer(), negative = comer(), still = comer();
  empty.places.clear();
  lost.places[3].y() = nan;
  negative.radius_m = -1.0;
  still.step_s = 0.0;
  for (const OtherUav& bad : {empty, lost, negative, still}) {
    EXPECT_THROW(planning::require_valid(bad), std::invalid_argument);
  }
}

}  // namespace
