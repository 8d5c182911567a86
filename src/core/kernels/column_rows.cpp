// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/column_rows.hpp"

#include "kernels/lanes.hpp"

namespace voxnav::kernels {
namespace {

using namespace lanes;  // NOLINT: the vector types of this file

constexpr int kSide = kBlockSideColumns;

VOXNAV_INLINE void add(ColumnRows rows) {
  for (; rows.count > 0; --rows.count, rows.from += kSide, rows.to += rows.row_length) {
    if (rows.up >= 0) {
      for (int x = 0; x < kSide; ++x) rows.to[x] |= std::uint32_t{rows.from[x]} << rows.up;
    } else {
      for (int x = 0; x < kSide; ++x) rows.to[x] |= std::uint32_t{rows.from[x]} >> -rows.up;
    }
  }
}
void add_plain(const ColumnRows& rows) { add(rows); }
VOXNAV_WIDE void add_wide(const ColumnRows& rows) { add(rows); }

VOXNAV_INLINE void add_turned(const std::uint32_t* window, int row_length, const TurnedBlock& at,
                              std::uint16_t* block) {
  const TurnedBlock b = at;  // a copy, so that the compiler knows that writing to the block does not change it
  const Ints lane = {0, 1, 2, 3, 4, 5, 6, 7};
  const Ints lanes_x = b.first.x + lane * b.right.x, lanes_y = b.first.y + lane * b.right.y;
  alignas(32) std::int32_t from[kLanes];
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; x += kLanes, block += kLanes) {
      const Ints at_x = lanes_x + (y * b.back.x + x * b.right.x);
      const Ints at_y = lanes_y + (y * b.back.y + x * b.right.y);
      store((at_y >> b.shift) * row_length + (at_x >> b.shift), from);
      for (int i = 0; i < kLanes; ++i) block[i] |= static_cast<std::uint16_t>(window[from[i]] >> b.lowest);
    }
  }
}
void add_turned_plain(const std::uint32_t* window, int row_length, const TurnedBlock& at, std::uint16_t* block) {
  add_turned(window, row_length, at, block);
}
VOXNAV_WIDE void add_turned_wide(const std::uint32_t* window, int row_length, const TurnedBlock& at,
                                 std::uint16_t* block) {
  add_turned(window, row_length, at, block);
}

}  // namespace

void add_rows(const ColumnRows& rows) { (is_wide() ? add_wide : add_plain)(rows); }

void add_turned_columns(const std::uint32_t* window, int row_length, const TurnedBlock& at, std::uint16_t* block) {
  (is_wide() ? add_turned_wide : add_turned_plain)(window, row_length, at, block);
}

void reference::add_rows(const ColumnRows& rows) {
  for (int y = 0; y < rows.count; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const std::uint32_t column = rows.from[y * kSide + x];
      rows.to[y * rows.row_length + x] |= rows.up >= 0 ? column << rows.up : column >> -rows.up;
    }
  }
}

void reference::add_turned_columns(const std::uint32_t* window, int row_length, const TurnedBlock& at,
                                   std::uint16_t* block) {
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const int window_x = (at.first.x + x * at.right.x + y * at.back.x) >> at.shift;
      const int window_y = (at.first.y + x * at.right.y + y * at.back.y) >> at.shift;
      block[x + kSide * y] |= static_cast<std::uint16_t>(window[window_x + row_length * window_y] >> at.lowest);
    }
  }
}

}  // namespace voxnav::kernels
