// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "room_world.hpp"
#include "scan_maker.hpp"
#include "steps.hpp"
#include "voxnav/occupancy/moving_things.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Aabb;
using geometry::Vec3;
using occupancy::LocalMap;
using occupancy::MovingThings;
using occupancy::MovingThingsConfig;
using test::RoomWorld;

namespace {

constexpr double kPeriod_s = 0.1;

occupancy::LocalMapConfig small_config(int num_threads = 1) {
  occupancy::LocalMapConfig config;
  config.window_size_m = {44, 44, 20};
  config.num_threads = num_threads;
  return config;
}

Aabb person_at(double x, double y) { return {Vec3(x - 0.25, y - 0.25, -1.4), Vec3(x + 0.25, y + 0.25, 0.3)}; }

/// A map, what moves in it, and a sensor that hovers in a hall.
struct Watch {
  explicit Watch(const MovingThingsConfig& config = {}, int num_threads = 1)
      : map(small_config(num_threads)), things(config) {}

  /// Takes a sweep of the hall with a further box in it.
  void see(const std::vector<Aabb>& boxes, const Vec3& sensor = Vec3(0.1, 0.1, 0.1)) {
    RoomWorld world = hall;
    world.boxes.insert(world.boxes.end(), boxes.begin(), boxes.end());
    const auto pose = [&](double) { return test::at(sensor.x(), sensor.y(), sensor.z()); };
    const test::RoomSweep sweep = sweep_of(world, pose, 0.0, 0.01, ++num_sweeps);
    map.insert(geometry::view_of(sweep.points_L), pose(0.0));
    things.update(&map, base::from_seconds(kPeriod_s * num_sweeps), sensor);
  }
  void see_for(double seconds, const std::vector<Aabb>& boxes) {
    for (int i = 0; i < static_cast<int>(seconds / kPeriod_s); ++i) see(boxes);
  }
  std::vector<occupancy::NewHit> clear_hits() const {
    std::vector<occupancy::NewHit> out;
    for (const occupancy::NewHit& hit : map.new_hits()) {
      if (hit.is_clear) out.push_back(hit);
    }
    return out;
  }
  /// A person walks along y at x = 3 m. Returns the y at which it is at last.
  double walk(double from_y, double to_y, double speed_mps) {
    const std::vector<double> way = test::steps(from_y, to_y, kPeriod_s * speed_mps);
    for (const double y : way) see({person_at(3.0, y)});
    return way.back();
  }
  std::size_t num_occupied(const Aabb& box) const {
    std::size_t count = 0;
    const std::vector<float> points = map.occupied_points();
    for (std::size_t i = 0; i < points.size(); i += 3) {
      count += box.contains(Vec3(points[i], points[i + 1], points[i + 2])) ? 1 : 0;
    }
    return count;
  }

  /// Voxels on the way of the person up to a y that are not known to be free.
  int num_not_free_behind(double y) const {
    int count = 0;
    for (Vec3 p(3.0, -4.6, 0.0); p.y() < y; p.y() += 0.4) {
      for (p.z() = -0.6; p.z() < 0.3; p.z() += 0.4) count += map.state(p) != VoxelState::kFree ? 1 : 0;
    }
    return count;
  }

  RoomWorld hall = RoomWorld::hall();
  LocalMap map;
  MovingThings things;
  std::uint32_t num_sweeps = 0;
};

/// Around the way of the person, above the voxels that hold the floor as well.
const Aabb kWay{Vec3(2.4, -5.2, -1.1), Vec3(3.5, 1.4, 0.7)};

std::size_t num_occupied(const occupancy::MapContent& content, const Aabb& box) {
  std::size_t count = 0;
  for (const auto& block : content.blocks) {
    for (const auto& voxel : block.occupied) {
      const Vec3 at = surface_point(block.index, voxel, content.resolution_m).cast<double>();
      count += box.contains(at) ? 1 : 0;
    }
  }
  return count;
}

TEST(MovingThings, APersonThatWalksIsFollowedWithItsVelocity) {
  Watch watch;
  watch.see_for(1.0, {});
  EXPECT_TRUE(watch.things.things().empty());
  const double y = watch.walk(-4.5, 1.0, 1.4);
  ASSERT_EQ(watch.things.things().size(), 1u);
  const occupancy::MovingThing& thing = watch.things.things().front();
  // The sides that are seen change while the person passes, and with them the middle of what is seen.
  EXPECT_NEAR(thing.velocity.y(), 1.4, 0.35);
  EXPECT_NEAR(thing.velocity.x(), 0.0, 0.35);
  EXPECT_NEAR(thing.position.y(), y, 0.35);
  EXPECT_NEAR(thing.position.x(), 3.0, 0.35);
  EXPECT_LT(thing.half_size_m.head<2>().maxCoeff(), 0.5);
}

TEST(MovingThings, WhatAPersonLeavesIsFreeSoonAfterwards) {
  Watch watch, unwatched(MovingThingsConfig{false});
  for (Watch* each : {&watch, &unwatched}) {
    each->see_for(1.0, {});
    ASSERT_EQ(each->num_occupied(kWay), 0u);
    each->walk(-4.5, 1.0, 1.4);
  }
  // Where the person is, the map must say so; farther than three sweeps behind, nothing is left.
  const Aabb here{Vec3(2.4, 0.3, -1.1), Vec3(3.5, 1.6, 0.7)};
  EXPECT_GT(watch.num_occupied(here), 0u);
  EXPECT_EQ(watch.num_not_free_behind(0.1), 0);
  EXPECT_GT(unwatched.num_not_free_behind(0.1), 0) << "the test shows nothing";
}

TEST(MovingThings, ContentThatIsHandedOverHoldsNoPersonThatWalks) {
  Watch watch;
  watch.see_for(1.0, {});
  watch.walk(-4.5, 0.0, 1.4);
  ASSERT_GT(watch.num_occupied(kWay), 0u);
  EXPECT_EQ(num_occupied(watch.map.content(), kWay), 0u);
  EXPECT_EQ(num_occupied(watch.map.hand_over(), kWay), 0u);
}

TEST(MovingThings, APersonThatStopsBecomesAPartOfTheMap) {
  Watch watch;
  watch.see_for(1.0, {});
  const double y = watch.walk(-4.5, -1.0, 1.4);
  ASSERT_EQ(watch.things.things().size(), 1u);
  watch.see_for(8.0, {person_at(3.0, y)});
  EXPECT_TRUE(watch.things.things().empty());
  EXPECT_GT(watch.num_occupied(kWay), 0u);
  EXPECT_GT(num_occupied(watch.map.content(), kWay), 0u);
}

TEST(MovingThings, AThingThatAppearsAndStaysIsNotTakenForMoving) {
  Watch watch;
  watch.see_for(1.0, {});
  watch.see_for(3.0, {person_at(3.0, -2.0)});
  EXPECT_TRUE(watch.things.things().empty());
  const std::size_t seen = watch.num_occupied(kWay);
  EXPECT_GT(seen, 0u);
  watch.see_for(5.0, {person_at(3.0, -2.0)});
  EXPECT_GE(watch.num_occupied(kWay), seen);
}

TEST(MovingThings, AThingThatIsHiddenForAMomentIsPredicted) {
  Watch watch;
  watch.see_for(1.0, {});
  const double y = watch.walk(-4.5, 0.0, 1.4);
  const std::uint32_t id = watch.things.things().at(0).id;
  const double sigma_m = watch.things.things().at(0).position_sigma_m;
  watch.see_for(0.5, {});
  ASSERT_EQ(watch.things.things().size(), 1u);
  EXPECT_EQ(watch.things.things()[0].id, id);
  EXPECT_NEAR(watch.things.things()[0].position.y(), y + 0.7, 0.5);
  EXPECT_GT(watch.things.things()[0].position_sigma_m, sigma_m);
  watch.see_for(1.5, {});
  EXPECT_TRUE(watch.things.things().empty());
}

/// A vehicle that flies sees static things in pieces, thin ones with gaps: nothing of that may be taken for moving.
TEST(MovingThings, AFlightThroughAStaticHallChangesNothing) {
  for (const double speed_mps : {1.0, 3.0, 6.0}) {
    Watch watch, unwatched(MovingThingsConfig{false});
    for (int i = 0; i < static_cast<int>(16.0 / (kPeriod_s * speed_mps)); ++i) {
      const Vec3 sensor(-8.0 + kPeriod_s * speed_mps * i, 0.5 * std::sin(0.1 * i), 0.1);
      const std::vector<Aabb> poles = {{Vec3(1.0, 1.5, -1.5), Vec3(1.03, 1.53, 5.0)},
                                       {Vec3(-2.0, -2.5, 0.8), Vec3(6.0, -2.49, 0.81)}};  // a wire
      watch.see(poles, sensor);
      unwatched.see(poles, sensor);
      EXPECT_TRUE(watch.things.things().empty()) << "at " << speed_mps << " m/s, sweep " << i;
    }
    EXPECT_EQ(watch.map.occupied_points(), unwatched.map.occupied_points());
  }
}

TEST(MovingThings, TheResultDoesNotDependOnTheNumberOfThreads) {
  Watch one, three({}, 3);
  for (Watch* each : {&one, &three}) {
    each->see_for(0.5, {});
    each->walk(-4.0, -1.0, 2.0);
  }
  EXPECT_EQ(one.map.content().to_bytes(), three.map.content().to_bytes());
  ASSERT_EQ(one.things.things().size(), three.things.things().size());
  EXPECT_EQ(one.things.things()[0].velocity, three.things.things()[0].velocity);
}

TEST(MovingThings, NewHitsAreThoseInSpaceThatWasFree) {
  Watch watch;
  watch.see_for(1.0, {});
  EXPECT_TRUE(watch.clear_hits().empty());
  watch.see({person_at(3.0, -2.0)});
  ASSERT_FALSE(watch.clear_hits().empty());
  for (const occupancy::NewHit& hit : watch.clear_hits()) {
    EXPECT_TRUE(hit.is_first);
    EXPECT_TRUE(person_at(3.0, -2.0).padded(0.1).contains(hit.point.cast<double>())) << hit.point.transpose();
    EXPECT_GT(hit.num_points, 0);
  }
  watch.see({person_at(3.0, -2.0)});
  ASSERT_FALSE(watch.clear_hits().empty());
  EXPECT_FALSE(watch.clear_hits().front().is_first);
}

TEST(MovingThings, ATimeThatJumpsBackForgetsWhatIsFollowed) {
  Watch watch;
  watch.see_for(1.0, {});
  watch.walk(-4.5, 0.0, 1.4);
  ASSERT_FALSE(watch.things.things().empty());
  watch.num_sweeps = 0;
  watch.see({});
  EXPECT_TRUE(watch.things.things().empty());
}

TEST(MovingThings, AConfigurationWithoutSenseIsRefused) {
  MovingThingsConfig config;
  config.min_speed_mps = 10.0;
  config.max_speed_mps = 5.0;
  EXPECT_THROW(MovingThings{config}, base::ConfigError);
}

}  // namespace
