// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "pipeline/terrain_map.hpp"

namespace voxnav::pipeline {
namespace {

constexpr std::uint32_t kWhole = (1u << TerrainColumn::kSide) - 1u;

}  // namespace

TerrainColumn::TerrainColumn(const Heights& lowest_occupied, const Heights& ground)
    : lowest_occupied_(lowest_occupied), ground_(ground) {
  for (const std::int32_t height : ground_) {
    if (height == kUnknown) {
      is_known_everywhere_ = false;
    } else if (low_ == kUnknown) {
      low_ = high_ = height;
    } else {
      low_ = std::min(low_, height);
      high_ = std::max(high_, height);
    }
  }
}

std::uint32_t TerrainColumn::outside(std::int32_t ground, int block_z, const HeightLimits& limits) {
  std::uint32_t out = 0;
  const std::int32_t bottom = block_z * kSide;
  if (limits.low) out |= (1u << std::clamp(ground + *limits.low - bottom, 0, kSide)) - 1u;
  if (limits.high) out |= kWhole & ~((1u << std::clamp(ground + *limits.high + 1 - bottom, 0, kSide)) - 1u);
  return out;
}

bool TerrainColumn::forbid(int block_z, const HeightLimits& limits, planning::BlockMask* hard) const {
  if (!is_known_anywhere()) return false;
  const std::uint32_t at_low = outside(low_, block_z, limits), at_high = outside(high_, block_z, limits);
  // What is outside varies with the ground in one sense for each limit, so between the two it is one of them.
  if (at_low == 0 && at_high == 0) return false;
  const bool is_below = limits.low && low_ + *limits.low >= (block_z + 1) * kSide;
  const bool is_above = limits.high && high_ + *limits.high < block_z * kSide;
  if (is_known_everywhere_ && (is_below || is_above)) {
    hard->set();
    return true;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto [it, is_new] = masks_.try_emplace(block_z, nullptr);
  if (is_new) it->second = make_mask(block_z, limits);
  *hard |= *it->second;
  return true;
}

std::unique_ptr<planning::BlockMask> TerrainColumn::make_mask(int block_z, const HeightLimits& limits) const {
  auto out = std::make_unique<planning::BlockMask>();
  for (std::size_t column = 0; column < kColumns; ++column) {
    if (ground_[column] == kUnknown) continue;
    for (std::uint32_t bits = outside(ground_[column], block_z, limits); bits != 0; bits &= bits - 1) {
      out->set(static_cast<std::size_t>(__builtin_ctz(bits)) * kColumns + column);
    }
  }
  return out;
}

}  // namespace voxnav::pipeline
