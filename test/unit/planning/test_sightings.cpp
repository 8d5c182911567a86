// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "planning/sightings.hpp"
#include "steps.hpp"

using namespace voxnav;  // NOLINT: test
using containers::MovingThing;
using geometry::Vec3;
using planning::first_meeting;
using planning::first_touch_m;
using planning::may_touch;
using planning::MovingRules;
using planning::Sightings;
using planning::TimedLine;

namespace {

MovingThing person(const Vec3& position, const Vec3& velocity) {
  MovingThing out;
  out.position = position;
  out.velocity = velocity;
  out.half_size_m = Vec3(0.3, 0.0, 0.9);
  out.position_sigma_m = 0.1;
  out.velocity_sigma_mps = 0.2;
  return out;
}

/// A straight line at constant speed along x.
TimedLine straight(double length_m, double speed_mps) {
  TimedLine out;
  for (const double x : test::steps(0.0, length_m + 0.1 * speed_mps, 0.2 * speed_mps)) {
    out.points.emplace_back(x, 0.0, 1.0);
    out.times_s.push_back(x / speed_mps);
  }
  return out;
}

TEST(Sightings, AThingIsAnUprightCylinderThatMovesOnAndGrows) {
  const MovingThing thing = person(Vec3(5, 0, 1), Vec3(0, 1, 0));
  const MovingRules rules{3.0, 0.3};
  EXPECT_TRUE(may_touch(thing, rules, 0.0, Vec3(4.0, 0, 1), 0.61));  // radius 0.3, grown by 0.1
  EXPECT_FALSE(may_touch(thing, rules, 0.0, Vec3(4.0, 0, 1), 0.59));
  EXPECT_FALSE(may_touch(thing, rules, 0.0, Vec3(5.0, 2.0, 1), 0.7));
  EXPECT_TRUE(may_touch(thing, rules, 2.0, Vec3(5.0, 2.0, 1), 0.7));
  EXPECT_TRUE(may_touch(thing, rules, 2.0, Vec3(3.1, 2.0, 1), 0.51));  // grown by 0.1 + 2 (0.2 + 0.3)
  EXPECT_FALSE(may_touch(thing, rules, 2.0, Vec3(3.1, 2.0, 1), 0.49));
  EXPECT_FALSE(may_touch(thing, rules, 0.0, Vec3(5.0, 0, 3.0), 0.9));  // above its head
}

TEST(Sightings, AFlightMeetsWhatCrossesItsWayInTime) {
  Sightings sightings;
  sightings.rules = {4.0, 0.0};
  sightings.things = {person(Vec3(6, -3, 1), Vec3(0, 1, 0))};
  const auto meeting = first_meeting(sightings, straight(12.0, 2.0), 0, 0.5);  // both are at the crossing after 3 s
  ASSERT_TRUE(meeting);
  EXPECT_GT(meeting->arc_m, 3.5);
  EXPECT_LT(meeting->arc_m, 6.0);
  EXPECT_FALSE(first_meeting(sightings, straight(12.0, 8.0), 0, 0.5)) << "it has passed when the person comes";
  sightings.things[0].velocity.y() = -1.0;
  EXPECT_FALSE(first_meeting(sightings, straight(12.0, 2.0), 0, 0.5)) << "the person walks away";
}

TEST(Sightings, AVehicleThatRestsMeetsWhatComes) {
  Sightings sightings;
  sightings.rules = {4.0, 0.0};
  sightings.things = {person(Vec3(4, 0, 1), Vec3(-1.5, 0, 0))};
  const TimedLine rest{{Vec3(0, 0, 1)}, {0.0}};
  const auto meeting = first_meeting(sightings, rest, 0, 0.5);
  ASSERT_TRUE(meeting);
  EXPECT_EQ(meeting->arc_m, 0.0);
  EXPECT_GT(meeting->after_s, 1.0);
  sightings.rules.horizon_s = 0.5;
  EXPECT_FALSE(first_meeting(sightings, rest, 0, 0.5));
}

TEST(Sightings, ThingsHaveMovedOnSinceTheirSweep) {
  Sightings sightings;
  sightings.stamp_ns = base::from_seconds(10.0);
  sightings.rules = {3.0, 0.0};
  sightings.things = {person(Vec3(3, 0, 1), Vec3(-2, 0, 0))};
  const TimedLine rest{{Vec3(0, 0, 1)}, {0.0}};
  const auto at_once = first_meeting(sightings, rest, base::from_seconds(10.0), 0.5);
  const auto later = first_meeting(sightings, rest, base::from_seconds(10.4), 0.5);
  ASSERT_TRUE(at_once && later);
  EXPECT_NEAR(at_once->after_s - later->after_s, 0.4, 0.06);
}

TEST(Sightings, MeetingsAreThoseOfBruteForce) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int num_met = 0;
  for (int round = 0; round < 300; ++round) {
    const auto vec = [&](double scale) {
      return Vec3(scale * uniform(random), scale * uniform(random), uniform(random));
    };
    Sightings sightings;
    sightings.rules = {3.0, 0.2};
    for (int i = 0; i < 3; ++i) sightings.things.push_back(person(vec(6.0), vec(2.0)));
    TimedLine line;
    for (int i = 0; i < 6; ++i) {
      line.points.push_back(i == 0 ? vec(4.0) : Vec3(line.points.back() + vec(1.0)));
      line.times_s.push_back(0.5 * i);
    }
    std::optional<double> first;
    for (int step = 0; step <= 3000 && !first; ++step) {
      const double t = 0.001 * step;
      const auto i = std::min<std::size_t>(static_cast<std::size_t>(t / 0.5), line.points.size() - 1);
      const std::size_t next = std::min(i + 1, line.points.size() - 1);
      const Vec3 at = line.points[i] + (t / 0.5 - static_cast<double>(i)) * (line.points[next] - line.points[i]);
      for (const MovingThing& thing : sightings.things) {
        if (may_touch(thing, sightings.rules, t, i == next ? line.points[i] : at, 0.5)) first = t;
      }
    }
    const auto found = first_meeting(sightings, line, 0, 0.5);
    num_met += found ? 1 : 0;
    // Times are 0.05 s apart, so that a touch of less may be overlooked, and is found by so much later.
    if (found) {
      ASSERT_TRUE(first) << "round " << round;
      EXPECT_NEAR(found->after_s, *first, 0.051) << "round " << round;
    } else if (first) {
      EXPECT_FALSE(first_meeting(sightings, line, 0, 0.4)) << "round " << round;
    }
  }
  EXPECT_GT(num_met, 50);
}

TEST(Sightings, ALineTouchesVoxelsWhereItComesWithinTheRadius) {
  const std::vector<Vec3> line = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(4, 4, 0)};
  EXPECT_NEAR(first_touch_m(line, 0.5, {{5, 0, 0}}, 0.4).value(), 1.5, 1e-3);  // from 2.0 m on
  EXPECT_NEAR(first_touch_m(line, 0.5, {{9, 7, 0}}, 0.4).value(), 6.3, 1e-2);  // around the corner, from y = 2.8 m on
  EXPECT_FALSE(first_touch_m(line, 0.5, {{5, 5, 0}, {0, 9, 0}}, 0.4));
  EXPECT_FALSE(first_touch_m(line, 0.5, {}, 0.4));
}

TEST(Sightings, TheRestOfATrajectoryBeginsWhereTheVehicleIs) {
  const planning::Trajectory trajectory({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(2.5, 0, 0)}, 0.5);
  const TimedLine rest = timed_line(trajectory, 0.6);
  ASSERT_EQ(rest.points.size(), 4u);
  EXPECT_NEAR(rest.points[0].x(), 0.6, 1e-12);
  EXPECT_NEAR(rest.times_s[1], 0.2, 1e-9);
  EXPECT_NEAR(rest.times_s[3], 1.2, 1e-9);
}

}  // namespace
