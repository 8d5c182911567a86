// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/terrain_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxnav::pipeline {
namespace {

using containers::StateBlock;
using geometry::Index3;

constexpr int kSide = geometry::kBlockSide;
constexpr std::uint64_t kLowBits = 0x5555555555555555ull;
constexpr std::int32_t kUnknown = std::numeric_limits<std::int32_t>::max();

}  // namespace

TerrainMap::TerrainMap(const containers::StateGrid& grid, const geometry::Vec3& vehicle)
    : resolution_m_(grid.resolution_m()) {
  read(grid, vehicle);
  const int reach = static_cast<int>(std::lround(kWindow_m / resolution_m_));
  heights_ = filtered(heights_, reach, [](std::int32_t a, std::int32_t b) { return std::min(a, b); });
  heights_ = filtered(heights_, reach, [](std::int32_t a, std::int32_t b) { return std::max(a, b); });
}

void TerrainMap::read(const containers::StateGrid& grid, const geometry::Vec3& vehicle) {
  const Index3 middle = geometry::index_of(vehicle, kSide * resolution_m_);
  constexpr int kBlocks = kRadius / kSide;
  std::vector<Index3> near;
  for (const Index3& block : grid.sorted_block_indices()) {
    if (std::abs(block.x - middle.x) <= kBlocks && std::abs(block.y - middle.y) <= kBlocks) near.push_back(block);
  }
  if (near.empty()) return;
  Index3 low = near.front(), high = near.front();
  for (const Index3& block : near) {
    low = {std::min(low.x, block.x), std::min(low.y, block.y), 0};
    high = {std::max(high.x, block.x), std::max(high.y, block.y), 0};
  }
  low_ = {low.x * kSide, low.y * kSide, 0};
  width_ = (high.x - low.x + 1) * kSide;
  depth_ = (high.y - low.y + 1) * kSide;
  heights_.assign(static_cast<std::size_t>(width_) * depth_, kUnknown);
  for (const Index3& block : near) {
    const StateBlock& states = *grid.find_block(block);
    for (int word = 0; word < static_cast<int>(states.words.size()); ++word) {
      // The higher bit of the two of a voxel is set if it is occupied.
      for (std::uint64_t bits = (states.words[word] >> 1) & kLowBits; bits != 0; bits &= bits - 1) {
        const Index3 voxel = geometry::voxel_at(block, word * 32 + __builtin_ctzll(bits) / 2);
        std::int32_t& lowest = heights_[static_cast<std::size_t>(voxel.y - low_.y) * width_ + (voxel.x - low_.x)];
        lowest = std::min(lowest, voxel.z);
      }
    }
  }
}

template <class Pick>
TerrainMap::Heights TerrainMap::filtered(const Heights& in, int reach, Pick pick) const {
  const auto pass = [&](const Heights& from, int length, int count, std::ptrdiff_t step, std::ptrdiff_t line) {
    Heights to(from.size(), kUnknown);
    for (int row = 0; row < count; ++row) {
      for (int i = 0; i < length; ++i) {
        std::int32_t& best = to[static_cast<std::size_t>(row * line + i * step)];
        for (int k = std::max(0, i - reach); k <= std::min(length - 1, i + reach); ++k) {
          const std::int32_t there = from[static_cast<std::size_t>(row * line + k * step)];
          if (there != kUnknown) best = best == kUnknown ? there : pick(best, there);
        }
      }
    }
    return to;
  };
  return pass(pass(in, width_, depth_, 1, width_), depth_, width_, width_, 1);
}

std::int32_t TerrainMap::at(int x, int y) const {
  const int column = x - low_.x, row = y - low_.y;
  if (column < 0 || row < 0 || column >= width_ || row >= depth_) return kUnknown;
  return heights_[static_cast<std::size_t>(row) * width_ + column];
}

std::optional<double> TerrainMap::height_m(int x, int y) const {
  const std::int32_t height = at(x, y);
  if (height == kUnknown) return std::nullopt;
  return (height + 1) * resolution_m_;
}

bool TerrainMap::knows_block(int x, int y) const {
  for (int i = 0; i < kSide * kSide; ++i) {
    if (at(x * kSide + i % kSide, y * kSide + i / kSide) != kUnknown) return true;
  }
  return false;
}

}  // namespace voxnav::pipeline
