// SPDX-License-Identifier: BSD-3-Clause
// The packed form of a submap keeps apart what the submap observed itself and what is only remembered.
#include <gtest/gtest.h>

#include <map>

#include "content_builder.hpp"
#include "resealed.hpp"
#include "submap/content/make_content.hpp"
#include "voxnav/submap/submap.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Index3;
using geometry::Pose;
using submap::Columns;
using submap::Submap;
using submap::SubmapContent;

namespace {

/// Returns random states, of which some are only remembered. Cells of 4 x 4 x 4 voxels are observed as a whole, in part
/// or not at all, because the packed form stores these three kinds in different ways.
occupancy::MapContent random_content(unsigned seed) {
  occupancy::MapContent content = test::random_content(seed, 40, 0.02, 0.2, 0.4);
  std::mt19937 rng(seed);
  for (occupancy::ContentBlock& block : content.blocks) {
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const Index3 voxel = geometry::voxel_at(block.index, offset);
      const int kind = ((voxel.x >> 2) + (voxel.y >> 2) + (voxel.z >> 2)) & 3;
      if (kind == 0 || (kind == 1 && rng() % 2 == 0))
        block.observed_free[offset >> 6] &= ~(std::uint64_t{1} << (offset & 63));
    }
    for (occupancy::OccupiedVoxel& leaf : block.occupied) {
      if (rng() % 2 == 0) leaf.observed.hits = 0;
    }
  }
  return content;
}

void expect_observed(const SubmapContent& packed, const occupancy::MapContent& content) {
  std::size_t checked = 0;
  for (const occupancy::ContentBlock& block : content.blocks) {
    const auto position = packed.states().find(block.index);
    ASSERT_TRUE(position);
    const Columns observed = packed.states().observed_free(*position);
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset, ++checked) {
      const bool expected = ((block.observed_free[offset >> 6] >> (offset & 63)) & 1u) != 0;
      ASSERT_EQ((observed[static_cast<std::size_t>(offset & 255)] >> (offset >> 8)) & 1, expected);
    }
  }
  ASSERT_GT(checked, 50000u);
}

}  // namespace

TEST(ObservedFree, EqualsThatOfTheContent) {
  const auto content = random_content(1);
  expect_observed(submap::make_content(content, 3.0), content);
}

TEST(ObservedFree, IsPartOfTheBytesOfTheSubmap) {
  const auto content = random_content(2);
  const auto original = Submap::from_content(content, Pose::Identity(), {});
  const auto copy = Submap::from_bytes(original->to_bytes());
  expect_observed(*copy->content(), content);
  EXPECT_EQ(copy->to_bytes(), original->to_bytes());
}

TEST(ObservedFree, OccupiedVoxelsHoldWhatIsBelievedAndWhatWasObserved) {
  const auto content = random_content(3);
  const SubmapContent packed = submap::make_content(content, 3.0);
  std::map<Index3, occupancy::OccupiedVoxel> expected;
  for (const occupancy::ContentBlock& block : content.blocks) {
    for (const occupancy::OccupiedVoxel& voxel : block.occupied)
      expected[geometry::voxel_at(block.index, voxel.offset)] = voxel;
  }
  std::size_t number = 0, num_observed = 0;
  for (std::size_t i = 0; i < packed.states().size(); ++i) {
    packed.for_each_voxel(i, [&](const occupancy::OccupiedVoxel& voxel, std::size_t n) {
      ASSERT_EQ(n, number++);
      const auto& wanted = expected.at(geometry::voxel_at(packed.states().index(i), voxel.offset));
      ASSERT_EQ(voxel.believed, wanted.believed);
      ASSERT_EQ(packed.points().believed(n), wanted.believed);
      ASSERT_EQ(packed.points().is_observed(n), wanted.observed.hits > 0);
      if (wanted.observed.hits == 0) return;
      ASSERT_EQ(voxel.observed, wanted.observed);
      ASSERT_EQ(voxel.observed_time, wanted.observed_time);
      ++num_observed;
    });
  }
  EXPECT_EQ(number, expected.size());
  EXPECT_EQ(num_observed, packed.points().num_observed());
  EXPECT_GT(num_observed, number / 3);
  EXPECT_LT(num_observed, 2 * number / 3);
}

TEST(ObservedFree, IsRefusedIfItDoesNotMatchTheStates) {
  const auto submap = Submap::from_content(random_content(4), Pose::Identity(), {});
  const std::string bytes = submap->to_bytes();
  // `behind` counts the bytes after the observed free space: points, times, observations that differ, bits of both,
  // whether there are distances, surface points, and the checksum.
  const submap::VoxelPoints& points = submap->content()->points();
  const auto in_words = [](std::size_t bits) { return 8 * ((bits + 63) / 64); };
  const std::size_t behind = std::size_t{3} * 8 + 4 * points.size() + points.num_observed() +
                             4 * points.differing().size() + in_words(points.size()) + in_words(points.num_observed()) +
                             1 + 8 + 4;
  for (const char wrong : {static_cast<char>(0xFF), '\0'}) {
    std::string broken = bytes;  // below its last word of free space is set to all voxels of a cell, or none
    for (std::size_t k = 1; k <= 8; ++k) broken[bytes.size() - behind - k] = wrong;
    try {
      Submap::from_bytes(test::resealed(broken));
      FAIL();
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("observed free space"), std::string::npos) << error.what();
    }
  }
}
