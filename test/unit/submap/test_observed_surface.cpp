// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "resealed.hpp"
#include "submap/registration/observed_surface.hpp"
#include "voxnav/submap/submap.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;
using submap::ObservedSurface;
using submap::Submap;

namespace {

constexpr double kVoxel = 0.4;

/// Returns free space between two walls perpendicular to x: the one at voxel 0 was observed, the one at voxel 12 is
/// only remembered. The submap observed the first at `observed_offset` in its voxels, while the mean of all hits is the
/// centre.
occupancy::MapContent two_walls(double observed_offset) {
  test::ContentBuilder builder(kVoxel);
  for (int z = -6; z < 6; ++z) {
    for (int y = -6; y < 6; ++y) {
      for (int x = 1; x < 12; ++x) builder.set_free({x, y, z});
      builder.set_occupied({0, y, z});
      builder.set_observed({0, y, z}, {observed_offset, 0, 0}, 5);
      builder.set_occupied({12, y, z});
      builder.set_observed({12, y, z}, Vec3::Zero(), 0);
    }
  }
  return builder.build();
}

constexpr std::size_t kPointList = 8;  ///< the bytes of the empty list of surface points at the end of a submap

std::optional<double> distance_at(const geometry::DistanceField& field, const Vec3& p) {
  double out = 0.0;
  if (!field.sample(p, &out, nullptr)) return std::nullopt;
  return out;
}

}  // namespace

TEST(ObservedSurface, HoldsObservedPointsWhereTheSubmapSawThem) {
  const auto submap = Submap::from_content(two_walls(0.25), Pose::Identity(), {});
  const auto own = submap::registration_field(submap);
  ASSERT_GT(own->surface_points().size(), 50u);
  for (const auto& point : own->surface_points()) EXPECT_NEAR(point.position.x(), 0.75 * kVoxel, 0.01);
  // Both points are 1 m before a wall: the first before the observed one, the second before the remembered one.
  const Vec3 near_seen(2.5 * kVoxel, 0.1, 0.1);
  const Vec3 near_remembered(10.5 * kVoxel, 0.1, 0.1);
  EXPECT_NEAR(*distance_at(*own, near_seen), 1.75 * kVoxel, 0.02);
  EXPECT_FALSE(distance_at(*own, near_remembered));
  // The field of the submap itself has both walls.
  EXPECT_NEAR(*distance_at(*submap, near_seen), 2.0 * kVoxel, 0.02);
  EXPECT_NEAR(*distance_at(*submap, near_remembered), 2.0 * kVoxel, 0.02);
  EXPECT_EQ(submap->occupied_points().size(), 2u * 144u);
}

TEST(ObservedSurface, IsPartOfTheBytesOfTheSubmap) {
  const auto original = Submap::from_content(two_walls(0.25), geometry::from_position_yaw({1, 2, 3}, 0.5), {});
  const auto copy = Submap::from_bytes(original->to_bytes());
  EXPECT_EQ(copy->to_bytes(), original->to_bytes());
  const ObservedSurface a(*original);
  const ObservedSurface b(*copy);
  std::mt19937 rng(1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = test::random_in(&rng, {-2, -2, -2}, {8, 6, 6});
    ASSERT_EQ(distance_at(a, p), distance_at(b, p));
  }
}

TEST(ObservedSurface, ObservedPointsThatMatchNoVoxelAreRefused) {
  const auto submap = Submap::from_content(two_walls(0.0), Pose::Identity(), {});
  std::string bytes = submap->to_bytes();
  // The bytes end with a bit per point that tells whether it was observed, a bit per observed point that tells whether
  // it differs from the believed one, whether there are distances, the surface points, and the checksum.
  const std::size_t behind = kPointList + 1 + 8 * ((submap->content()->points().num_observed() + 63) / 64);
  bytes[bytes.size() - 4 - behind - 1] = static_cast<char>(0xFF);  // the last bits per point
  EXPECT_THROW(Submap::from_bytes(test::resealed(bytes)), std::invalid_argument);
}
