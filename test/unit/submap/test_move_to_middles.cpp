// SPDX-License-Identifier: BSD-3-Clause
// Trunks are hit on their near side: before the vehicle passes them on one side, and afterwards on the other. Submaps
// that are registered by these hits as they are follow the vehicle by up to a trunk's diameter.
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "steps.hpp"
#include "submap/registration/observed_surface.hpp"
#include "voxnav/submap/submap.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;

namespace {

constexpr double kVoxel = 0.4;
constexpr double kRadius_m = 0.15;
constexpr double kMeanDepth_m = 2.0 / M_PI * kRadius_m;  ///< mean distance of the visible half from the axis

/// Returns trunks 3 m apart on flat ground as seen from `from`. Each trunk has one occupied voxel per layer, whose
/// point is the mean of the hits on the visible side.
occupancy::MapContent grove_seen_from(const Vec3& from) {
  test::ContentBuilder builder(kVoxel);
  for (int y = -20; y < 20; ++y) {
    for (int x = -20; x < 20; ++x) {
      for (int z = 0; z < 12; ++z) builder.set_free({x, y, z});
      builder.set_occupied({x, y, -1}, Vec3(0.0, 0.0, 0.25));
    }
  }
  for (const double x : test::steps(-6.2, 7.0, 3.0)) {
    for (const double y : test::steps(-6.2, 7.0, 3.0)) {
      for (int z = 1; z < 10; ++z) {
        const Vec3 axis(x, y, (z + 0.5) * kVoxel);
        Vec3 towards = from - axis;
        towards.z() = 0.0;
        const Vec3 hit = axis + kMeanDepth_m * towards.normalized();
        const geometry::Index3 voxel = geometry::index_of(hit, kVoxel);
        builder.set_occupied(voxel, (hit - geometry::center_of(voxel, kVoxel)) / kVoxel);
      }
    }
  }
  return builder.build();
}

std::shared_ptr<const submap::Submap> submap_from(const Vec3& from) {
  return submap::Submap::from_content(grove_seen_from(from), Pose::Identity(), {});
}

std::vector<geometry::StampedPose> hovering_at(const Vec3& place) {
  return {{0, geometry::from_position_yaw(place, 0.3)}, {1000, geometry::from_position_yaw(place, 0.4)}};
}

geometry::SurfacePoint nearest_to(const geometry::Vec3f& p, const std::vector<geometry::SurfacePoint>& points) {
  return *std::min_element(points.begin(), points.end(), [&](const auto& l, const auto& r) {
    return (l.position - p).squaredNorm() < (r.position - p).squaredNorm();
  });
}

/// Returns the mean distance along x from the trunks of `a` to those of `b`, positive if those of `b` have larger x.
double shift_along_x(const geometry::DistanceField& a, const geometry::DistanceField& b) {
  double sum = 0.0;
  int count = 0;
  for (const auto& p : a.surface_points()) {
    if (p.position.z() < kVoxel) continue;
    sum += nearest_to(p.position, b.surface_points()).position.x() - p.position.x();
    ++count;
  }
  return sum / count;
}

}  // namespace

TEST(MoveToMiddles, TrunksSeenFromBothSidesAgree) {
  const Vec3 before(-15.0, 0.0, 1.0), after(15.0, 0.0, 1.0);
  const auto a = submap_from(before), b = submap_from(after);
  const double as_hit = shift_along_x(*submap::registration_field(a), *submap::registration_field(b));
  EXPECT_GT(as_hit, 1.5 * kMeanDepth_m);
  const double as_middles = shift_along_x(*submap::registration_field(a, hovering_at(before)),
                                          *submap::registration_field(b, hovering_at(after)));
  EXPECT_LT(std::abs(as_middles), 0.35 * as_hit);
}

TEST(MoveToMiddles, PlanesStayAndOtherPointsMoveAwayFromTheSensor) {
  const Vec3 place(-15.0, 3.0, 4.0);
  const auto submap = submap_from(place);
  const auto as_hit = submap::registration_field(submap);
  const auto as_middles = submap::registration_field(submap, hovering_at(place));
  ASSERT_EQ(as_hit->surface_points().size(), as_middles->surface_points().size());
  std::size_t num_moved = 0;
  for (const auto& p : as_middles->surface_points()) {
    const auto hit = nearest_to(p.position, as_hit->surface_points());
    const bool is_inside_ground = p.position.z() < 0.f && p.position.head<2>().cwiseAbs().maxCoeff() < 7.0f;
    const Vec3 moved = (p.position - hit.position).cast<double>();
    EXPECT_LT(moved.norm(), is_inside_ground ? 1e-4 : 0.102);
    if (moved.norm() > 0.01 && p.position.z() > 0.f) {
      EXPECT_GT(moved.dot(p.position.cast<double>() - place), 0.0);
      ++num_moved;
    }
  }
  EXPECT_GT(num_moved, 100u);
}

/// Each point is moved away from the pose at the time when it was observed, which is the last pose here.
TEST(MoveToMiddles, PointsMoveAwayFromThePoseAtTheirTime) {
  const Vec3 first(-15.0, 0.0, 1.0), last(15.0, 0.0, 1.0);
  occupancy::MapContent content = grove_seen_from(first);
  for (occupancy::ContentBlock& block : content.blocks) {
    for (occupancy::OccupiedVoxel& leaf : block.occupied) leaf.observed_time = 255;
  }
  const auto submap = submap::Submap::from_content(content, Pose::Identity(), {});
  const std::vector<geometry::StampedPose> history{{0, geometry::from_position_yaw(first, 0.0)},
                                                   {1000, geometry::from_position_yaw(last, 0.0)}};
  const auto as_hit = submap::registration_field(submap);
  const auto moved = submap::registration_field(submap, history);
  EXPECT_LT(shift_along_x(*as_hit, *moved), -0.02);
  EXPECT_GT(shift_along_x(*as_hit, *submap::registration_field(submap, hovering_at(first))), 0.02);
}
