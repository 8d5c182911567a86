// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/terrain_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "pipeline/opening.hpp"

namespace voxnav::pipeline {
namespace {

using containers::StateBlock;
using geometry::Index3;
using Heights = TerrainColumn::Heights;

constexpr int kSide = geometry::kBlockSide;
constexpr std::uint64_t kLowBits = 0x5555555555555555ull;
constexpr std::int32_t kUnknown = TerrainColumn::kUnknown;

Index3 at_bottom(const Index3& block) { return {block.x, block.y, 0}; }

/// Lowers the heights to the lowest occupied voxels of a block.
void lower(const Index3& block, const StateBlock& states, Heights* heights) {
  for (int word = 0; word < static_cast<int>(states.words.size()); ++word) {
    // The higher bit of the two of a voxel is set if it is occupied.
    for (std::uint64_t bits = (states.words[word] >> 1) & kLowBits; bits != 0; bits &= bits - 1) {
      const int offset = word * 32 + __builtin_ctzll(bits) / 2;
      std::int32_t& lowest = (*heights)[static_cast<std::size_t>(offset % (kSide * kSide))];
      lowest = std::min(lowest, block.z * kSide + offset / (kSide * kSide));
    }
  }
}

/// Calls what(index) for the columns of blocks up to a distance from one, itself included.
template <class What>
void for_each_near(const Index3& block, int reach, What what) {
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) what(Index3{block.x + dx, block.y + dy, 0});
  }
}

}  // namespace

TerrainMap::Lowest TerrainMap::read(const containers::StateGrid& grid, const geometry::Vec3& vehicle) {
  constexpr int kBlocks = kRadius / kSide;
  const Index3 middle = geometry::index_of(vehicle, kSide * grid.resolution_m());
  Lowest out;
  for (const auto& [block, states] : grid.blocks()) {
    if (std::abs(block.x - middle.x) > kBlocks || std::abs(block.y - middle.y) > kBlocks) continue;
    const auto [it, is_new] = out.try_emplace(at_bottom(block));
    if (is_new) it->second.fill(kUnknown);
    lower(block, states, &it->second);
  }
  return out;
}

TerrainMap::TerrainMap(const containers::StateGrid& grid, const geometry::Vec3& vehicle, const TerrainMap* before)
    : resolution_m_(grid.resolution_m()), reach_(static_cast<int>(std::lround(kWindow_m / resolution_m_))) {
  if (before != nullptr && before->resolution_m_ != resolution_m_) before = nullptr;
  const Lowest lowest = read(grid, vehicle);
  const int reach = (2 * reach_ + kSide - 1) / kSide;
  std::set<Index3> changed;  // columns of blocks whose ground may be another one
  for (const auto& [block, heights] : lowest) {
    const TerrainColumn* old = before == nullptr ? nullptr : before->column(block.x, block.y);
    if (old != nullptr && old->lowest_occupied() == heights) continue;
    for_each_near(block, reach, [&](const Index3& near) { changed.insert(near); });
  }
  if (before != nullptr) {
    for (const auto& entry : before->columns_) {
      if (lowest.count(entry.first) > 0) continue;
      for_each_near(entry.first, reach, [&](const Index3& near) { changed.insert(near); });
    }
  }
  for (const auto& [block, heights] : lowest) {
    if (before != nullptr && changed.count(block) == 0) {
      columns_.emplace(block, before->columns_.at(block));
      continue;
    }
    const Heights ground = ground_of(block, lowest);
    const auto old = before == nullptr ? Columns::const_iterator() : before->columns_.find(block);
    const bool is_same = before != nullptr && old != before->columns_.end() && old->second->ground() == ground &&
                         old->second->lowest_occupied() == heights;
    columns_.emplace(block, is_same ? old->second : std::make_shared<const TerrainColumn>(heights, ground));
  }
}

Heights TerrainMap::ground_of(const Index3& block, const Lowest& lowest) const {
  const int reach = (2 * reach_ + kSide - 1) / kSide, margin = reach * kSide;
  Opening opening(kSide, margin, reach_);
  for_each_near(block, reach, [&](const Index3& near) {
    const auto found = lowest.find(near);
    if (found == lowest.end()) return;
    const int x0 = (near.x - block.x) * kSide, y0 = (near.y - block.y) * kSide;
    for (int y = 0; y < kSide; ++y)
      opening.set_row(x0, y0 + y, &found->second[static_cast<std::size_t>(y) * kSide], kSide);
  });
  Heights out;
  opening.run(&out[0]);
  return out;
}

std::optional<double> TerrainMap::height_m(int x, int y) const {
  const Index3 voxel{x, y, 0}, block = geometry::block_of(voxel);
  const TerrainColumn* there = column(block.x, block.y);
  if (there == nullptr) return std::nullopt;
  const std::int32_t height = there->ground()[static_cast<std::size_t>(geometry::offset_in_block(voxel))];
  if (height == kUnknown) return std::nullopt;
  return (height + 1) * resolution_m_;
}

const TerrainColumn* TerrainMap::column(int block_x, int block_y) const {
  const auto found = columns_.find(Index3{block_x, block_y, 0});
  return found == columns_.end() ? nullptr : found->second.get();
}

std::shared_ptr<const TerrainMap> TerrainSource::terrain_of(const containers::StateGrid& grid,
                                                            const geometry::Vec3& vehicle) {
  const std::lock_guard<std::mutex> lock(mutex_);
  newest_ = std::make_shared<const TerrainMap>(grid, vehicle, newest_.get());
  return newest_;
}

}  // namespace voxnav::pipeline
