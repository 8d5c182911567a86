// SPDX-License-Identifier: BSD-3-Clause
// A fire truck drives from one place to another between two visits to a yard.
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "voxnav/submap/submap_collection.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;
using submap::SceneChange;
using submap::SubmapCollection;

namespace {

constexpr double kVoxel = 0.4;
const Vec3 kOldPlace(-4.0, -6.0, 1.5);
const Vec3 kNewPlace(5.0, 6.0, 1.5);

double box_sdf(const Vec3& p, const Vec3& center, const Vec3& half) {
  const Vec3 q = (p - center).cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

double truck_sdf(const Vec3& p, const Vec3& place) { return box_sdf(p, place, {3.5, 1.25, 1.4}); }

double static_sdf(const Vec3& p) {
  const double ground = p.z() - 0.07;
  const double house = box_sdf(p, {-10.0, 8.0, 3.0}, {3.0, 2.5, 3.1});
  const double pole = std::hypot(p.x() - 1.1, p.y() + 9.3) - 0.12;
  const double wall = 12.9 - p.x();
  return std::min({ground, house, pole, wall});
}

/// Returns the yard with the truck at a place, in a grid at T_W_G.
occupancy::MapContent yard(const Vec3& place, const Pose& T_W_G) {
  const auto sdf = [&](const Vec3& p_G) {
    const Vec3 p = T_W_G * p_G;
    return std::min(static_sdf(p), truck_sdf(p, place));
  };
  return test::content_from_sdf(sdf, {-36, -36, -3}, {36, 36, 18}, kVoxel);
}

submap::SubmapEntry entry_of(std::uint32_t id, const Vec3& place, const Pose& T_W_G, const Pose& T_W_S) {
  submap::SubmapEntry entry;
  entry.id = id;
  entry.end_ns = id;
  entry.T_W_S = T_W_S;
  entry.submap = submap::Submap::from_content(yard(place, T_W_G), Pose::Identity(), {});
  return entry;
}

std::size_t count_old_truck(const std::vector<geometry::Vec3f>& points) {
  std::size_t count = 0;
  for (const auto& p : points) {
    const Vec3 q = p.cast<double>();
    count += truck_sdf(q, kOldPlace) < 0.4 && q.z() > 0.5;
  }
  return count;
}

class FireTruck : public ::testing::TestWithParam<unsigned> {
 protected:
  FireTruck() : rng_(GetParam()) {
    collection_.add(entry_of(1, kOldPlace, Pose::Identity(), Pose::Identity()));
    before_ = collection_.occupied_points();
    T_W_G_ = geometry::from_position_yaw(test::random_in(&rng_, {-2, -2, -0.2}, {2, 2, 0.2}), 0.4);
    const Pose drift = geometry::from_position_yaw(test::random_in(&rng_, {-0.6, -0.6, -0.5}, {0.6, 0.6, 0.5}), 0.01);
    collection_.add(entry_of(2, kNewPlace, T_W_G_, drift * T_W_G_));
    collection_.update();
  }
  /// Corrects the second pose as optimisation would, with errors of decimetres in the plane and centimetres in height.
  void optimise() {
    const Pose rest = geometry::from_position_yaw(test::random_in(&rng_, {-0.1, -0.1, -0.05}, {0.1, 0.1, 0.05}), 0.003);
    collection_.set_pose(2, rest * T_W_G_);
  }

  std::mt19937 rng_;
  SubmapCollection collection_{submap::SubmapCollectionConfig{}};
  std::vector<geometry::Vec3f> before_;
  Pose T_W_G_;
};

}  // namespace

TEST_P(FireTruck, IsInItsNewPlaceOnlyOnceTheYardWasSeenAgain) {
  optimise();
  const std::size_t old_truck = count_old_truck(before_);
  ASSERT_GT(old_truck, 300u);
  EXPECT_LE(count_old_truck(collection_.occupied_points()), old_truck / 20);
}

TEST_P(FireTruck, NothingStaticIsLost) {
  optimise();
  collection_.update();
  std::size_t total = 0;
  std::size_t lost = 0;
  for (const auto& p : before_) {
    const Vec3 point = p.cast<double>();
    if (truck_sdf(point, kOldPlace) < 0.8) continue;
    ++total;
    lost += !collection_.evidence().nearest_surface(point, 1.25 * kVoxel).has_value();
  }
  ASSERT_GT(total, 5000u);
  EXPECT_LE(static_cast<double>(lost), 0.005 * static_cast<double>(total));
}

TEST_P(FireTruck, IsReportedAsGoneThereAndNewHere) {
  optimise();
  const auto nearest_of = [&](SceneChange::Kind kind, const Vec3& place) {
    double nearest = 1e9;
    for (const SceneChange& change : collection_.changes(50)) {
      if (change.kind == kind) nearest = std::min(nearest, (change.center_W - place).norm());
      EXPECT_EQ(change.submap_id, 2u);
    }
    return nearest;
  };
  EXPECT_LT(nearest_of(SceneChange::Kind::kDisappeared, kOldPlace), 0.8);
  EXPECT_LT(nearest_of(SceneChange::Kind::kAppeared, kNewPlace), 0.8);
  EXPECT_LE(collection_.changes(50).size(), 4u);
}

INSTANTIATE_TEST_SUITE_P(Seeds, FireTruck, ::testing::Values(1u, 2u, 3u, 4u, 5u));
