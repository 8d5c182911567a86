// SPDX-License-Identifier: BSD-3-Clause
#include "planning/clearance/squared_distances.hpp"

#include <algorithm>

#include "voxnav/planning/clearance_field.hpp"

namespace voxnav::planning {
namespace {

constexpr int kSide = geometry::kBlockSide;
constexpr auto kFar = static_cast<std::int16_t>(ClearanceField::kFar);

std::int16_t squared_face(int offset) {
  return static_cast<std::int16_t>(offset == 0 ? 0 : (2 * offset - 1) * (2 * offset - 1));
}

/// The column (x, y) relative to the middle block over the heights -16 to 31, lowest first.
std::uint64_t tall_column(const SurroundingColumns& set, int x, int y) {
  const int below = (x >> geometry::kBlockShift) + 1 + 3 * ((y >> geometry::kBlockShift) + 1);
  const int column = column_at(x & (kSide - 1), y & (kSide - 1));
  std::uint64_t out = 0;
  for (int dz = 0; dz < 3; ++dz) {
    const BlockColumns* block = set.blocks[below + 9 * dz];
    const std::uint64_t bits = block != nullptr ? (*block)[column] : (set.absent_is_set ? kWholeColumn : 0u);
    out |= bits << (kSide * dz);
  }
  return out;
}

/// Distance from a height (from -16 on) to the nearest set bit of a tall column that is not empty.
int nearest_bit(std::uint64_t bits, int height) {
  const std::uint64_t above = bits >> height;
  const std::uint64_t below = bits << (63 - height);
  const int up = above != 0 ? __builtin_ctzll(above) : 64;
  const int down = below != 0 ? __builtin_clzll(below) : 64;
  return std::min(up, down);
}

template <class Column>
void take_least(const Column& in, std::int16_t weight, Column* out) {
  for (int z = 0; z < kSide; ++z) (*out)[z] = std::min((*out)[z], static_cast<std::int16_t>(in[z] + weight));
}

}  // namespace

SquaredDistanceTransform::SquaredDistanceTransform(int reach, int limit) : reach_(reach), limit_(limit) {
  const std::size_t side = kSide + 2 * static_cast<std::size_t>(reach);
  for (int k = 0; k <= reach; ++k) weights_.push_back(squared_face(k));
  heights_.resize(side * side);
  rows_.resize(side * side);
}

bool SquaredDistanceTransform::compute(const SurroundingColumns& set, const ColumnRange& range,
                                       ClearanceDistances* out) {
  along_z(set, range);
  along_x(range);
  along_y(range, out);
  return std::any_of(&has_row_[range.x0], &has_row_[range.x0] + (range.x1 - range.x0),
                     [](std::uint64_t rows) { return rows != 0; });
}

void SquaredDistanceTransform::along_z(const SurroundingColumns& set, const ColumnRange& range) {
  // Bits within reach of the middle block.
  const std::uint64_t near = ((std::uint64_t{1} << (kSide + 2 * reach_)) - 1) << (kSide - reach_);
  for (int y = range.y0 - reach_; y < range.y1 + reach_; ++y) {
    std::uint64_t& has_height = has_height_[y + reach_];
    has_height = 0;
    for (int x = range.x0 - reach_; x < range.x1 + reach_; ++x) {
      const std::uint64_t bits = tall_column(set, x, y) & near;
      if (bits == 0) continue;
      const int at = halo_at(x, y);
      has_height |= std::uint64_t{1} << (x + reach_);
      if (((bits >> kSide) & kWholeColumn) == kWholeColumn) {
        heights_[at].fill(0);
        continue;
      }
      for (int z = 0; z < kSide; ++z) {
        const int nearest = nearest_bit(bits, z + kSide);
        heights_[at][z] = nearest <= reach_ ? weights_[nearest] : kFar;
      }
    }
  }
}

void SquaredDistanceTransform::along_x(const ColumnRange& range) {
  for (int x = range.x0; x < range.x1; ++x) has_row_[x] = 0;
  for (int y = range.y0 - reach_; y < range.y1 + reach_; ++y) {
    for (int x = range.x0; x < range.x1; ++x) {
      std::uint64_t near = within_reach(has_height_[y + reach_], x);
      if (near == 0) continue;
      has_row_[x] |= std::uint64_t{1} << (y + reach_);
      Column least;
      least.fill(kFar);
      for (; near != 0; near &= near - 1) {
        const int dx = __builtin_ctzll(near) - reach_;
        take_least(heights_[halo_at(x + dx, y)], weights_[std::abs(dx)], &least);
      }
      rows_[halo_at(x, y)] = least;
    }
  }
}

void SquaredDistanceTransform::along_y(const ColumnRange& range, ClearanceDistances* out) const {
  for (int y = range.y0; y < range.y1; ++y) {
    for (int x = range.x0; x < range.x1; ++x) {
      Column least;
      least.fill(kFar);
      for (std::uint64_t near = within_reach(has_row_[x], y); near != 0; near &= near - 1) {
        const int dy = __builtin_ctzll(near) - reach_;
        take_least(rows_[halo_at(x, y + dy)], weights_[std::abs(dy)], &least);
      }
      std::int16_t* to = &(*out)[static_cast<std::size_t>(column_at(x, y)) * kSide];
      for (int z = 0; z < kSide; ++z) to[z] = least[z] <= limit_ ? least[z] : kFar;
    }
  }
}

}  // namespace voxnav::planning
