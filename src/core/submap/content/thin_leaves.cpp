// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/thin_leaves.hpp"

#include <memory>

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;

/// Of 26. A line has two, where it changes its row up to four; a plane has eight, its edge five, its corner three.
constexpr int kMostNeighbors = 4;

/// Occupied voxels of a field as columns, unpacked block by block.
class Occupied {
 public:
  explicit Occupied(const CompressedField& field) : field_(field), blocks_(field.num_blocks()) {}

  bool is_thin(const Index3& voxel) {
    const Index3 low = voxel - Index3{1, 1, 1};
    const bool is_inside = ((voxel.x + 1) & 15) > 1 && ((voxel.y + 1) & 15) > 1 && ((voxel.z + 1) & 15) > 1;
    int count = -1;  // itself
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
    const int position = field_.position_of(block);
    if (position < 0) return nullptr;
    std::unique_ptr<Columns>& columns = blocks_[static_cast<std::size_t>(position)];
    if (!columns) columns = std::make_unique<Columns>(field_.columns(static_cast<std::size_t>(position)).occupied);
    return columns.get();
  }
  bool is_occupied(const Index3& voxel) {
    const Columns* columns = columns_of(geometry::block_of(voxel));
    const int offset = geometry::offset_in_block(voxel);
    return columns && (((*columns)[static_cast<std::size_t>(offset & 255)] >> (offset >> 8)) & 1);
  }

  const CompressedField& field_;
  std::vector<std::unique_ptr<Columns>> blocks_;
};

}  // namespace

std::vector<bool> find_thin(const CompressedField& field) {
  std::vector<bool> out;
  out.reserve(field.num_leaves());
  Occupied occupied(field);
  field.for_each_leaf(
      [&](const Index3& voxel, const CompressedField::Leaf&) { out.push_back(occupied.is_thin(voxel)); });
  return out;
}

}  // namespace voxnav::submap
