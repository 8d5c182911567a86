// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/octree_levels.hpp"

#include <algorithm>

#include "kernels/processor.hpp"

namespace voxnav::kernels {
namespace {

struct Max {
  VOXNAV_INLINE std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const { return a > b ? a : b; }
};
struct Or {
  VOXNAV_INLINE std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const {
    return static_cast<std::uint8_t>(a | b);
  }
};

/// Eight children to one parent over a whole level of Side^3 nodes. Rows are combined first, so that the compiler
/// turns the inner loop into vector instructions.
template <int Side, class Combine>
VOXNAV_INLINE void reduce(const std::uint8_t* in, std::uint8_t* out, Combine combine) {
  constexpr int kHalf = Side / 2;
  for (int z = 0; z < kHalf; ++z) {
    for (int y = 0; y < kHalf; ++y) {
      const int first = (2 * z * Side + 2 * y) * Side;
      const std::uint8_t* row = in + first;
      std::uint8_t merged[Side];
      for (int x = 0; x < Side; ++x) {
        merged[x] = combine(combine(row[x], row[x + Side]), combine(row[x + Side * Side], row[x + Side * Side + Side]));
      }
      for (int x = 0; x < kHalf; ++x) out[(z * kHalf + y) * kHalf + x] = combine(merged[2 * x], merged[2 * x + 1]);
    }
  }
}

template <class Combine>
VOXNAV_INLINE void reduce_all(const std::uint8_t* voxels, std::uint8_t* nodes, Combine combine) {
  reduce<16>(voxels, nodes, combine);
  reduce<8>(nodes, nodes + 512, combine);
  reduce<4>(nodes + 512, nodes + 576, combine);
  reduce<2>(nodes + 576, nodes + 584, combine);
}

VOXNAV_INLINE void find_flags(const std::uint8_t* levels, const LevelFlags& by, std::uint8_t* flags) {
  const LevelFlags local = by;  // a copy, so that the compiler knows that writing the flags does not change it
  for (int i = 0; i < kBlockVoxels; ++i) {
    const std::uint8_t level = levels[i];
    const std::uint8_t not_free = level >= local.occupied_begin ? local.if_occupied : local.if_unknown;
    flags[i] = level < local.free_end ? local.if_free : not_free;
  }
}
void find_flags_plain(const std::uint8_t* levels, const LevelFlags& by, std::uint8_t* flags) {
  find_flags(levels, by, flags);
}
VOXNAV_WIDE void find_flags_wide(const std::uint8_t* levels, const LevelFlags& by, std::uint8_t* flags) {
  find_flags(levels, by, flags);
}

void summarise_plain(const std::uint8_t* levels, const std::uint8_t* flags, std::uint8_t* highest,
                     std::uint8_t* united) {
  reduce_all(levels, highest, Max{});
  reduce_all(flags, united, Or{});
}
VOXNAV_WIDE void summarise_wide(const std::uint8_t* levels, const std::uint8_t* flags, std::uint8_t* highest,
                                std::uint8_t* united) {
  reduce_all(levels, highest, Max{});
  reduce_all(flags, united, Or{});
}

}  // namespace

void flags_of_levels(const std::uint8_t* levels, const LevelFlags& by, std::uint8_t* flags) {
  (is_wide() ? find_flags_wide : find_flags_plain)(levels, by, flags);
}

void summarise_levels(const std::uint8_t* levels, const std::uint8_t* flags, std::uint8_t* highest,
                      std::uint8_t* united) {
  (is_wide() ? summarise_wide : summarise_plain)(levels, flags, highest, united);
}

void reference::flags_of_levels(const std::uint8_t* levels, const LevelFlags& by, std::uint8_t* flags) {
  for (int i = 0; i < kBlockVoxels; ++i) {
    if (levels[i] < by.free_end) {
      flags[i] = by.if_free;
    } else {
      flags[i] = levels[i] >= by.occupied_begin ? by.if_occupied : by.if_unknown;
    }
  }
}

void reference::summarise_levels(const std::uint8_t* levels, const std::uint8_t* flags, std::uint8_t* highest,
                                 std::uint8_t* united) {
  std::fill(highest, highest + kBlockNodes, std::uint8_t{0});
  std::fill(united, united + kBlockNodes, std::uint8_t{0});
  int first = 0;
  for (int edge = 2; edge <= 16; edge *= 2) {  // voxels along a node of the level
    const int side = 16 / edge;
    for (int i = 0; i < kBlockVoxels; ++i) {
      const int x = (i % 16) / edge, y = (i / 16 % 16) / edge, z = (i / 256) / edge;
      const int node = first + x + side * (y + side * z);
      highest[node] = std::max(highest[node], levels[i]);
      united[node] = static_cast<std::uint8_t>(united[node] | flags[i]);
    }
    first += side * side * side;
  }
}

}  // namespace voxnav::kernels
