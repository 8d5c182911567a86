// SPDX-License-Identifier: BSD-3-Clause
#include "planning/clearance/block_columns.hpp"

#include <algorithm>

namespace voxnav::planning {
namespace {
constexpr int kSide = geometry::kBlockSide;
}

void columns_of(const StateBlock& states, BlockColumns* occupied, BlockColumns* unknown) {
  occupied->fill(0);
  unknown->fill(0);
  for (int z = 0; z < kSide; ++z) {
    for (int column = 0; column < kColumns; column += 32) {
      std::uint64_t word = states.words[(z * kColumns + column) / 32];
      for (int i = column; i < column + 32; ++i, word >>= 2) {
        // Free is 1, occupied 2, unknown 0.
        (*occupied)[i] = static_cast<std::uint16_t>((*occupied)[i] | ((word >> 1) & 1u) << z);
        (*unknown)[i] = static_cast<std::uint16_t>((*unknown)[i] | (~(word | (word >> 1)) & 1u) << z);
      }
    }
  }
}

BlockColumns columns_of(const BlockMask& mask) {
  BlockColumns out{};
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    if (mask[offset])
      out[offset % kColumns] = static_cast<std::uint16_t>(out[offset % kColumns] | 1u << (offset / kColumns));
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
