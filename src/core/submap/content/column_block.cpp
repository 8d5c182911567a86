// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/column_block.hpp"

#include <algorithm>

namespace voxnav::submap {
namespace {

using geometry::kBlockSide;
using Square = std::array<std::uint16_t, kBlockSide>;

/// Transposes a matrix of 16 x 16 bits. Source: Warren, Hacker's Delight, section 7-3.
void transpose(Square* square) {
  std::uint16_t mask = 0x00FF;
  for (int j = 8; j != 0; j >>= 1, mask = static_cast<std::uint16_t>(mask ^ (mask << j))) {
    for (int k = 0; k < kBlockSide; k = (k + j + 1) & ~j) {
      const auto low = static_cast<std::size_t>(k);
      const std::size_t high = low + static_cast<std::size_t>(j);
      const auto swap = static_cast<std::uint16_t>((((*square)[low] >> j) ^ (*square)[high]) & mask);
      (*square)[high] ^= swap;
      (*square)[low] = static_cast<std::uint16_t>((*square)[low] ^ (swap << j));
    }
  }
}

/// Spreads bits apart: bit i moves to bit 2 i.
std::uint32_t spread(std::uint32_t bits) {
  bits = (bits | (bits << 8)) & 0x00FF00FFu;
  bits = (bits | (bits << 4)) & 0x0F0F0F0Fu;
  bits = (bits | (bits << 2)) & 0x33333333u;
  return (bits | (bits << 1)) & 0x55555555u;
}

/// Gathers bits: bit 2 i moves to bit i. Odd bits must be 0.
std::uint16_t gather(std::uint32_t bits) {
  bits = (bits | (bits >> 1)) & 0x33333333u;
  bits = (bits | (bits >> 2)) & 0x0F0F0F0Fu;
  bits = (bits | (bits >> 4)) & 0x00FF00FFu;
  return static_cast<std::uint16_t>(bits | (bits >> 8));
}

/// Converts the columns with the same y to rows along x, one for each z.
Square rows_at(const Columns& columns, int y) {
  Square square;
  std::copy_n(&columns[column_at(0, y)], kBlockSide, square.begin());
  transpose(&square);
  return square;
}

}  // namespace

bool ColumnBlock::all_unknown() const {
  const auto is_zero = [](std::uint16_t word) { return word == 0; };
  return std::all_of(free.begin(), free.end(), is_zero) && std::all_of(occupied.begin(), occupied.end(), is_zero);
}

containers::StateBlock to_states(const ColumnBlock& block) {
  containers::StateBlock out;
  for (int y = 0; y < kBlockSide; ++y) {
    const Square free = rows_at(block.free, y);
    const Square occupied = rows_at(block.occupied, y);
    for (std::size_t z = 0; z < kBlockSide; ++z) {
      const auto only_free = static_cast<std::uint16_t>(free[z] & ~occupied[z]);
      const std::uint64_t row = spread(only_free) | (spread(occupied[z]) << 1);
      out.words[z * 8 + static_cast<std::size_t>(y >> 1)] |= row << (32 * (y & 1));
    }
  }
  return out;
}

ColumnBlock to_columns(const containers::StateBlock& states) {
  ColumnBlock out;
  for (int y = 0; y < kBlockSide; ++y) {
    Square free;
    Square occupied;
    for (std::size_t z = 0; z < kBlockSide; ++z) {
      const auto row =
          static_cast<std::uint32_t>(states.words[z * 8 + static_cast<std::size_t>(y >> 1)] >> (32 * (y & 1)));
      free[z] = gather(row & 0x55555555u);
      occupied[z] = gather((row >> 1) & 0x55555555u);
    }
    transpose(&free);
    transpose(&occupied);
    std::copy(free.begin(), free.end(), &out.free[column_at(0, y)]);
    std::copy(occupied.begin(), occupied.end(), &out.occupied[column_at(0, y)]);
  }
  return out;
}

}  // namespace voxnav::submap
