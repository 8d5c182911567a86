// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/thin_voxels.hpp"

#include <memory>

namespace voxnav::submap {
namespace {

using geometry::Index3;

/// Highest number of occupied voxels among the 26 neighbours of a thin one. A voxel of a line has two, up to four where
/// the line changes its row; a voxel of a plane has eight, at its edge five, at its corner three.
constexpr int kMostNeighbors = 4;

/// The occupied voxels of a submap as columns, unpacked block by block when they are first asked for.
class Occupied {
 public:
  explicit Occupied(const BlockStates& states) : states_(states), blocks_(states.size()) {}

  bool is_thin(const Index3& voxel) {
    const Index3 low = voxel - Index3{1, 1, 1};
    const bool is_inside = ((voxel.x + 1) & 15) > 1 && ((voxel.y + 1) & 15) > 1 && ((voxel.z + 1) & 15) > 1;
    int count = -1;  // does not count the voxel itself
    const Columns* here = is_inside ? columns_of(geometry::block_of(voxel)) : nullptr;
    for (int i = 0; i < 9 && count <= kMostNeighbors; ++i) {
      const Index3 at = low + Index3{i % 3, i / 3, 0};
      if (here) {
        const std::uint16_t column = (*here)[static_cast<std::size_t>((at.x & 15) | ((at.y & 15) << 4))];
        count += __builtin_popcount((column >> (at.z & 15)) & 7u);
      } else {
        for (int z = 0; z < 3; ++z) count += is_occupied(at + Index3{0, 0, z});
      }
    }
    return count <= kMostNeighbors;
  }

 private:
  const Columns* columns_of(const Index3& block) {
    const auto position = states_.find(block);
    if (!position) return nullptr;
    std::unique_ptr<Columns>& columns = blocks_[*position];
    if (!columns) columns = std::make_unique<Columns>(states_.columns(*position).occupied);
    return columns.get();
  }
  bool is_occupied(const Index3& voxel) {
    const Columns* columns = columns_of(geometry::block_of(voxel));
    const int offset = geometry::offset_in_block(voxel);
    return columns && (((*columns)[static_cast<std::size_t>(offset & 255)] >> (offset >> 8)) & 1);
  }

  const BlockStates& states_;
  std::vector<std::unique_ptr<Columns>> blocks_;
};

}  // namespace

std::vector<bool> find_thin(const BlockStates& states) {
  std::vector<bool> out;
  out.reserve(states.num_occupied());
  Occupied occupied(states);
  for (std::size_t i = 0; i < states.size(); ++i) {
    states.for_each_occupied(i, [&](int offset, std::size_t) {
      out.push_back(occupied.is_thin(geometry::voxel_at(states.index(i), offset)));
    });
  }
  return out;
}

}  // namespace voxnav::submap
