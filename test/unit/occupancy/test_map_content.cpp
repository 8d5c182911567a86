// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "resealed.hpp"
#include "voxnav/occupancy/map_content.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using occupancy::ContentBlock;
using occupancy::MapContent;

namespace {

void set_observed_free(int offset, ContentBlock* block) {
  block->observed_free[offset >> 6] |= std::uint64_t{1} << (offset & 63);
}

bool is_observed_free(const MapContent& content, const geometry::Index3& index, int offset) {
  for (const ContentBlock& block : content.blocks) {
    if (block.index == index) return ((block.observed_free[offset >> 6] >> (offset & 63)) & 1u) != 0;
  }
  return false;
}

MapContent random_content(unsigned seed) {
  std::mt19937 rng(seed);
  MapContent content;
  content.resolution_m = 0.4;
  for (int x = -2; x < 2; ++x) {
    if (rng() % 4 == 0) continue;
    ContentBlock block;
    block.index = {x, 1, 0};
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const VoxelState state = static_cast<VoxelState>(rng() % 3);
      block.states.set(offset, state);
      if (state == VoxelState::kFree && rng() % 3 == 0) set_observed_free(offset, &block);
      if (state != VoxelState::kOccupied) continue;
      const auto signed_byte = [&] { return static_cast<std::int8_t>(static_cast<int>(rng() % 255) - 127); };
      occupancy::OccupiedVoxel leaf{
          static_cast<std::uint16_t>(offset),
          {{signed_byte(), signed_byte(), signed_byte()}, static_cast<std::uint8_t>(rng() % 256)}};
      leaf.observed.hits = static_cast<std::uint8_t>(rng() % 3);
      if (leaf.observed.hits > 0) leaf.observed.mean = {signed_byte(), signed_byte(), signed_byte()};
      block.occupied.push_back(leaf);
    }
    content.blocks.push_back(block);
  }
  return content;
}

VoxelState state_of(const MapContent& content, const geometry::Index3& index, int offset) {
  for (const ContentBlock& block : content.blocks) {
    if (block.index == index) return block.states.get(offset);
  }
  return VoxelState::kUnknown;
}

}  // namespace

TEST(MapContent, BytesRoundTrip) {
  const MapContent content = random_content(1);
  const MapContent read = MapContent::from_bytes(content.to_bytes());
  EXPECT_EQ(read.to_bytes(), content.to_bytes());
  EXPECT_EQ(read.num_occupied(), content.num_occupied());
}

TEST(MapContent, TruncatedBytesAreRefused) {
  const std::string bytes = random_content(1).to_bytes();
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    EXPECT_THROW(MapContent::from_bytes(bytes.substr(0, size)), std::invalid_argument);
  }
}

TEST(MapContent, BytesOfAnotherVersionAreRefusedWithBothVersions) {
  const std::string bytes = test::as_version(3, random_content(1).to_bytes());
  EXPECT_EQ(test::refusal_of([&] { MapContent::from_bytes(bytes); }),
            "map content has version 3 of its format; this program reads version 1 only");
}

TEST(MapContent, MergePrefersKnownVoxelsOfTheNewerContent) {
  const MapContent older = random_content(2);
  const MapContent newer = random_content(3);
  MapContent merged = older;
  merged.merge(newer);
  for (int x = -2; x < 2; ++x) {
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const VoxelState newest = state_of(newer, {x, 1, 0}, offset);
      const VoxelState expected = newest == VoxelState::kUnknown ? state_of(older, {x, 1, 0}, offset) : newest;
      ASSERT_EQ(state_of(merged, {x, 1, 0}, offset), expected);
      const MapContent& source = newest == VoxelState::kUnknown ? older : newer;
      ASSERT_EQ(is_observed_free(merged, {x, 1, 0}, offset), is_observed_free(source, {x, 1, 0}, offset));
    }
  }
  EXPECT_EQ(MapContent::from_bytes(merged.to_bytes()).num_occupied(), merged.num_occupied());
}

TEST(MapContent, ObservedFreeSpaceThatIsNotFreeIsRefused) {
  MapContent content = random_content(1);
  ContentBlock& block = content.blocks.front();
  int offset = 0;
  while (block.states.get(offset) == VoxelState::kFree) ++offset;
  set_observed_free(offset, &block);
  EXPECT_THROW(MapContent::from_bytes(content.to_bytes()), std::invalid_argument);
}

TEST(MapContent, SurfacePointStaysInsideItsVoxel) {
  const occupancy::OccupiedVoxel leaf{0, {{127, -127, 0}, 1}};
  const geometry::Vec3f p = occupancy::surface_point({0, 0, 0}, leaf, 0.4);
  EXPECT_NEAR(p.x(), 0.4, 1e-6);
  EXPECT_NEAR(p.y(), 0.0, 1e-6);
  EXPECT_NEAR(p.z(), 0.2, 1e-6);
}
