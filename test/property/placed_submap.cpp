// SPDX-License-Identifier: BSD-3-Clause
// A submap that is placed in the grid of the map, in integers and columns, is compared with the submap itself voxel by
// voxel.
#include "submap/merged/placed_submap.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "content_builder.hpp"
#include "sparse_bits.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Index3;
using geometry::Pose;
using geometry::Vec3;
using submap::Columns;
using submap::Knowledge;
using submap::PlacedPoints;
using submap::PlacedSubmap;
using submap::SurfaceEvidence;

namespace {

constexpr double kVoxel = 0.4;

struct Placement {
  const char* name;
  Pose T_W_S;
  double resolution_m;  ///< resolution of the map in W
};

std::vector<Placement> placements() {
  const Pose tilted =
      Pose(Eigen::AngleAxisd(0.3, Vec3(1, 2, 0).normalized())) * geometry::from_position_yaw(Vec3::Zero(), 2.0);
  return {{"where it is", Pose::Identity(), kVoxel},
          {"turned a little", geometry::from_position_yaw({7.13, -3.3, 0.71}, 0.05), kVoxel},
          {"turned", geometry::from_position_yaw({-70.7, 300.03, -5.2}, -2.2), kVoxel},
          {"turned by an eighth", geometry::from_position_yaw({0.17, 0.26, 0.09}, 0.785398), kVoxel},
          {"tilted", geometry::from_position_yaw({1.0, 2.0, 3.0}, 0.0) * tilted, kVoxel},
          {"into smaller voxels", geometry::from_position_yaw({1.0, 2.0, 3.0}, 0.4), 0.15},
          {"into larger voxels", geometry::from_position_yaw({1.0, 2.0, 3.0}, 0.4), 1.1}};
}

/// Returns a submap with random states, of which some are only remembered.
std::shared_ptr<submap::Submap> random_submap(unsigned seed) {
  occupancy::MapContent content = test::random_content(seed, 34, 0.03, 0.3, kVoxel);
  std::mt19937 rng(seed);
  for (occupancy::ContentBlock& block : content.blocks) {
    for (std::uint64_t& word : block.observed_free) word &= ~test::sparse_bits(&rng, 2);
    for (occupancy::OccupiedVoxel& leaf : block.occupied) {
      leaf.observed.mean[0] = static_cast<std::int8_t>(leaf.observed.mean[0] / 2);
      if (rng() % 3 == 0) leaf.observed.hits = 0;
    }
  }
  return submap::Submap::from_content(content, geometry::from_position_yaw({0.1, 0.2, 0.3}, 0.2), {});
}

/// Returns the blocks of W that a submap may touch.
std::vector<Index3> blocks_of(const submap::Submap& submap, const Placement& where) {
  return submap::footprint(submap, {where.T_W_S}, where.resolution_m, Knowledge::kAll);
}

std::vector<Vec3> observed_points(const submap::Submap& submap, const Pose& T_W_S) {
  std::vector<Vec3> out;
  submap.content()->for_each_voxel([&](const Index3& index, const occupancy::OccupiedVoxel& voxel) {
    if (voxel.observed.hits == 0) return;
    out.push_back(T_W_S * submap.T_S_G() * Vec3(submap::surface_point(index, voxel.observed) * kVoxel));
  });
  return out;
}

Vec3 point_of(const Index3& block, const SurfaceEvidence& leaf, double resolution_m) {
  return (Vec3(block.x, block.y, block.z) * geometry::kBlockSide + submap::local_point(leaf)) * resolution_m;
}

std::vector<Vec3> placed_points(const PlacedSubmap& placed, const std::vector<Index3>& blocks, double resolution_m) {
  std::vector<Vec3> out;
  for (const Index3& index : blocks) {
    const PlacedPoints::Block* block = placed.points().find(index);
    if (!block) continue;
    for (const SurfaceEvidence* leaf = placed.points().begin(*block); leaf != placed.points().end(*block); ++leaf)
      out.push_back(point_of(index, *leaf, resolution_m));
  }
  return out;
}

/// Returns whether the submap observed free space at a point; nothing if the point is too close to another voxel to
/// tell.
std::optional<bool> is_observed_free(const submap::Submap& submap, const Vec3& p_S) {
  const Vec3 p = submap.T_S_G().inverse() * p_S / submap.resolution_m();
  if (((p.array() - p.array().round()).abs() < 1e-5).any()) return std::nullopt;
  const Index3 voxel = geometry::index_of(p, 1.0);
  const submap::BlockStates& states = submap.content()->states();
  const auto position = states.find(geometry::block_of(voxel));
  if (!position) return false;
  const int offset = geometry::offset_in_block(voxel);
  const Columns free = states.observed_free(*position);
  return ((free[static_cast<std::size_t>(offset & 255)] >> (offset >> 8)) & 1) != 0;
}

}  // namespace

TEST(PlacedSubmap, EveryObservedPointIsWhereItBelongs) {
  const auto submap = random_submap(1);
  for (const Placement& where : placements()) {
    const PlacedSubmap placed(*submap, 7, {where.T_W_S}, where.resolution_m, Knowledge::kObserved);
    std::vector<Vec3> expected = observed_points(*submap, where.T_W_S);
    std::vector<Vec3> actual = placed_points(placed, blocks_of(*submap, where), where.resolution_m);
    ASSERT_EQ(actual.size(), expected.size()) << where.name;
    ASSERT_GT(actual.size(), 300u);
    const double quantum = 0.51 * std::sqrt(3.0) * where.resolution_m / submap::kUnitsPerEdge;
    for (const Vec3& p : expected) {
      const auto nearest = std::min_element(actual.begin(), actual.end(), [&](const Vec3& a, const Vec3& b) {
        return (a - p).squaredNorm() < (b - p).squaredNorm();
      });
      ASSERT_LT((*nearest - p).norm(), quantum) << where.name;
      *nearest = actual.back();
      actual.pop_back();
    }
  }
}

TEST(PlacedSubmap, ColumnsHoldTheirOwnPointsAndNoOthers) {
  const auto submap = random_submap(2);
  for (const Placement& where : placements()) {
    const PlacedSubmap placed(*submap, 7, {where.T_W_S}, where.resolution_m, Knowledge::kObserved);
    for (const Index3& index : blocks_of(*submap, where)) {
      const PlacedPoints::Block* block = placed.points().find(index);
      if (!block) continue;
      Columns seen{};
      std::size_t column = 0;
      std::uint32_t number = block->first.front();
      for (const SurfaceEvidence* leaf = placed.points().begin(*block); leaf != placed.points().end(*block);
           ++leaf, ++number) {
        while (number >= block->first.at(column + 1)) ++column;
        ASSERT_EQ(leaf->offset & 255u, column) << where.name;
        seen[column] = static_cast<std::uint16_t>(seen[column] | 1u << (leaf->offset >> 8));
      }
      ASSERT_EQ(seen, block->occupied) << where.name;
    }
  }
}

TEST(PlacedSubmap, SurfaceWithinADistanceEqualsBruteForce) {
  const auto submap = random_submap(3);
  std::mt19937 rng(5);
  for (const Placement& where : placements()) {
    const PlacedSubmap placed(*submap, 7, {where.T_W_S}, where.resolution_m, Knowledge::kObserved);
    const auto blocks = blocks_of(*submap, where);
    const auto points = placed_points(placed, blocks, where.resolution_m);
    int near = 0;
    for (int i = 0; i < 1500; ++i) {
      const Index3 index = blocks[rng() % blocks.size()];
      const auto coordinate = [&] { return static_cast<int>(rng() % 5000) - 300; };  // in units, also outside the block
      const submap::Units3 p{coordinate(), coordinate(), coordinate()};
      const Vec3 p_W =
          (Vec3(index.x, index.y, index.z) * geometry::kBlockSide + Vec3(p.x, p.y, p.z) / submap::kUnitsPerEdge) *
          where.resolution_m;
      double nearest = 1e9;
      for (const Vec3& q : points) nearest = std::min(nearest, (q - p_W).norm());
      const double distance_m = 0.1 + 0.0008 * (i % 1000);  // every 50th distance below goes over several blocks
      const double reach = i % 50 == 0 ? 8.0 : distance_m;
      if (std::abs(nearest - reach) < 1e-9) continue;
      const PlacedPoints::Around around(placed.points(), index);
      ASSERT_EQ(around.has_within(p, reach / where.resolution_m), nearest < reach) << where.name << " " << i;
      near += nearest < reach;
    }
    EXPECT_GT(near, 5) << where.name;
  }
}

TEST(PlacedSubmap, FreeSpaceIsThatOfTheVoxelsUnderneath) {
  const auto submap = random_submap(4);
  std::mt19937 rng(6);
  for (const Placement& where : placements()) {
    const PlacedSubmap placed(*submap, 7, {where.T_W_S}, where.resolution_m, Knowledge::kObserved);
    const Pose T_S_W = where.T_W_S.inverse();
    int num_free = 0;
    for (const Index3& index : blocks_of(*submap, where)) {
      const PlacedSubmap::FreeInBlock free(placed, index);
      Columns columns{};
      free.add_to(&columns);
      for (int i = 0; i < 200; ++i) {
        SurfaceEvidence leaf{};
        leaf.offset = static_cast<std::uint16_t>(rng() % geometry::kBlockVolume);
        const Vec3 center = geometry::center_of(geometry::voxel_at(index, leaf.offset), where.resolution_m);
        const auto at_center = is_observed_free(*submap, T_S_W * center);
        if (at_center) {
          ASSERT_EQ((columns[leaf.offset & 255u] >> (leaf.offset >> 8)) & 1, *at_center) << where.name;
        }
        for (std::int8_t& c : leaf.point.mean) c = static_cast<std::int8_t>(static_cast<int>(rng() % 255) - 127);
        const Vec3 p_W = point_of(index, leaf, where.resolution_m);
        const auto here = is_observed_free(*submap, T_S_W * p_W);
        const auto below = is_observed_free(*submap, T_S_W * Vec3(p_W - Vec3(0, 0, where.resolution_m)));
        if (here) {
          ASSERT_EQ(free.is_free(leaf).at_point, *here) << where.name;
          num_free += *here;
        }
        if (below) {
          ASSERT_EQ(free.is_free(leaf).below, *below) << where.name;
        }
        const auto above = is_observed_free(*submap, T_S_W * Vec3(p_W + Vec3(0, 0, where.resolution_m)));
        if (above) {
          // What lies above the block may be beyond the window, and counts as not free then.
          const bool is_within = (leaf.offset >> 8) + 1 < geometry::kBlockSide;
          ASSERT_TRUE(free.is_free(leaf).above == *above || (!is_within && *above)) << where.name;
        }
      }
    }
    EXPECT_GT(num_free, 25) << where.name;
  }
}
