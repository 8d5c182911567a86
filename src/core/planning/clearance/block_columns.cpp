// SPDX-License-Identifier: BSD-3-Clause
#include "planning/clearance/block_columns.hpp"

#include <algorithm>

namespace voxnav::planning {
namespace {
constexpr int kSide = geometry::kBlockSide;

/// Gathers the lower bits of the 32 pairs of a word.
std::uint32_t low_bits(std::uint64_t word) {
  word &= 0x5555555555555555u;
  word = (word | (word >> 1)) & 0x3333333333333333u;
  word = (word | (word >> 2)) & 0x0F0F0F0F0F0F0F0Fu;
  word = (word | (word >> 4)) & 0x00FF00FF00FF00FFu;
  word = (word | (word >> 8)) & 0x0000FFFF0000FFFFu;
  return static_cast<std::uint32_t>(word | (word >> 16));
}

/// Sets the bit of a height in all columns whose bits are set in a layer's 32 columns.
void set_height(std::uint32_t columns, int first, int z, BlockColumns* out) {
  for (std::uint32_t bits = columns; bits != 0; bits &= bits - 1) {
    std::uint16_t& column = (*out)[static_cast<std::size_t>(first) + static_cast<std::size_t>(__builtin_ctz(bits))];
    column = static_cast<std::uint16_t>(column | 1u << z);
  }
}

}  // namespace

void columns_of(const StateBlock& states, BlockColumns* occupied, BlockColumns* unknown) {
  // Free is 1, occupied 2, unknown 0.
  occupied->fill(0);
  BlockColumns known{};
  for (int z = 0; z < kSide; ++z) {
    for (int column = 0; column < kColumns; column += 32) {
      const std::uint64_t word = states.words[(z * kColumns + column) / 32];
      if (word == 0) continue;
      set_height(low_bits(word >> 1), column, z, occupied);
      set_height(low_bits(word) | low_bits(word >> 1), column, z, &known);
    }
  }
  for (int i = 0; i < kColumns; ++i) (*unknown)[i] = static_cast<std::uint16_t>(~known[i]);
}

BlockColumns columns_of(const BlockMask& mask) {
  BlockColumns out{};
  if (mask.none()) return out;
  if (mask.all()) {
    out.fill(kWholeColumn);
    return out;
  }
  for (std::size_t word = 0; word < BlockMask::kNumWords; ++word) {
    const std::size_t first = word * 64 % kColumns, z = word * 64 / kColumns;
    for (std::uint64_t bits = mask.words()[word]; bits != 0; bits &= bits - 1) {
      std::uint16_t& column = out[first + static_cast<std::size_t>(__builtin_ctzll(bits))];
      column = static_cast<std::uint16_t>(column | 1u << z);
    }
  }
  return out;
}

std::array<std::uint16_t, geometry::kBlockSide> rows_of(const BlockColumns& columns) {
  std::array<std::uint16_t, kSide> out{};
  for (int i = 0; i < kColumns; ++i) {
    if (columns[i] != 0) out[i / kSide] = static_cast<std::uint16_t>(out[i / kSide] | 1u << (i % kSide));
  }
  return out;
}

void ColumnRange::extend(const ColumnRange& other) {
  x0 = std::min(x0, other.x0);
  y0 = std::min(y0, other.y0);
  x1 = std::max(x1, other.x1);
  y1 = std::max(y1, other.y1);
}

ColumnRange ColumnRange::reach(int margin, int dx, int dy) const {
  if (empty()) return {};
  return {std::max(0, x0 - margin - dx * kSide), std::max(0, y0 - margin - dy * kSide),
          std::min(kSide, x1 + margin - dx * kSide), std::min(kSide, y1 + margin - dy * kSide)};
}

}  // namespace voxnav::planning
