// SPDX-License-Identifier: BSD-3-Clause
// Free space that a submap saw itself, beside what is only remembered, in its compressed form.
#include <gtest/gtest.h>

#include "base/bytes.hpp"
#include "content_builder.hpp"
#include "voxnav/submap/submap.hpp"

using namespace voxnav;  // NOLINT: test
using containers::State;
using geometry::Index3;
using geometry::Pose;
using submap::Columns;
using submap::CompressedField;
using submap::Submap;

namespace {

/// Random states, of which some are remembered; whole cells of 4^3 voxels too, own and remembered.
occupancy::MapContent random_content(unsigned seed) {
  occupancy::MapContent content = test::random_content(seed, 40, 0.02, 0.2, 0.4);
  std::mt19937 rng(seed);
  for (occupancy::ContentBlock& block : content.blocks) {
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const Index3 voxel = geometry::voxel_at(block.index, offset);
      const int kind = ((voxel.x >> 2) + (voxel.y >> 2) + (voxel.z >> 2)) & 3;
      if (kind == 0 || (kind == 1 && rng() % 2 == 0))
        block.own_free[offset >> 6] &= ~(std::uint64_t{1} << (offset & 63));
    }
    for (occupancy::OccupiedLeaf& leaf : block.occupied) {
      if (rng() % 2 == 0) leaf.own_hits = 0;
    }
  }
  return content;
}

void expect_own(const CompressedField& field, const occupancy::MapContent& content) {
  std::size_t checked = 0;
  for (const occupancy::ContentBlock& block : content.blocks) {
    const int position = field.position_of(block.index);
    ASSERT_GE(position, 0);
    const Columns own = field.own_free(static_cast<std::size_t>(position));
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset, ++checked) {
      const bool expected = ((block.own_free[offset >> 6] >> (offset & 63)) & 1u) != 0;
      ASSERT_EQ((own[static_cast<std::size_t>(offset & 255)] >> (offset >> 8)) & 1, expected);
    }
  }
  ASSERT_GT(checked, 50000u);
}

std::string sealed(const std::string& bytes) {
  base::ByteWriter out;
  out.put_raw(bytes.data(), bytes.size() - 4);
  return out.finish();
}

}  // namespace

TEST(OwnFree, IsWhatTheContentSaid) {
  const auto content = random_content(1);
  expect_own(CompressedField(content, 3.0), content);
}

TEST(OwnFree, TravelsWithTheSubmap) {
  const auto content = random_content(2);
  const auto original = Submap::from_content(content, Pose::Identity(), {});
  const auto copy = Submap::from_bytes(original->to_bytes());
  expect_own(*copy->field(), content);
  EXPECT_EQ(copy->to_bytes(), original->to_bytes());
}

TEST(OwnFree, OwnLeavesKeepTheirPlaceAmongAll) {
  const CompressedField field(random_content(3), 3.0);
  std::vector<Index3> all;
  field.for_each_leaf([&](const Index3& voxel, const CompressedField::Leaf&) { all.push_back(voxel); });
  std::size_t own = 0;
  field.for_each_own_leaf([&](const Index3& voxel, const CompressedField::Leaf& leaf, std::size_t i, std::uint8_t) {
    ASSERT_EQ(voxel, all.at(i));
    ASSERT_GT(leaf.hits, 0);
    ++own;
  });
  EXPECT_GT(own, all.size() / 3);
  EXPECT_LT(own, 2 * all.size() / 3);
}

TEST(OwnFree, WhatDoesNotMatchTheStatesIsRefused) {
  const auto submap = Submap::from_content(random_content(4), Pose::Identity(), {});
  const std::string bytes = submap->to_bytes();
  for (const char wrong : {static_cast<char>(0xFF), '\0'}) {
    std::string broken = bytes;  // the last word: all of a cell, or none
    for (std::size_t k = 1; k <= 8; ++k) broken[bytes.size() - 4 - 8 - k] = wrong;
    EXPECT_THROW(Submap::from_bytes(sealed(broken)), std::invalid_argument);
  }
}
