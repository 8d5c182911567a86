// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/make_content.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <stdexcept>

#include "submap/content/block_states_builder.hpp"

namespace voxnav::submap {
namespace {

using containers::VoxelState;
using occupancy::ContentBlock;
using occupancy::OccupiedVoxel;

[[noreturn]] void fail_mismatch() {
  throw std::invalid_argument("map content has occupied voxels that do not match its states");
}

/// A mean of -128 lies outside of its voxel and would break the symmetry of what is computed from it.
bool is_outside(const occupancy::VoxelPoint& point) {
  return point.mean[0] == -128 || point.mean[1] == -128 || point.mean[2] == -128;
}

OccupiedVoxel clamped(OccupiedVoxel voxel) {
  for (occupancy::VoxelPoint* point : {&voxel.believed, &voxel.observed})
    for (std::int8_t& c : point->mean) c = std::max<std::int8_t>(c, -127);
  return voxel;
}

/// Numbers of the occupied voxels of a block, cell by cell and within a cell by rising offset. The voxels themselves
/// stay where they are, because copies of them took half the time of filling a submap.
struct VoxelsByCell {
  /// Where the numbers of a cell begin; the next entry is where they end.
  std::array<std::uint16_t, kCellsOfBlock + 1> first{};
  std::array<std::uint16_t, geometry::kBlockVolume> numbers;

  void sort(const ContentBlock& block);
};

void VoxelsByCell::sort(const ContentBlock& block) {
  first.fill(0);
  int last = -1;
  for (const OccupiedVoxel& voxel : block.occupied) {
    const bool fits = voxel.offset < geometry::kBlockVolume && voxel.offset > last &&
                      block.states.get(voxel.offset) == VoxelState::kOccupied;
    if (!fits) fail_mismatch();
    last = voxel.offset;
    ++first[static_cast<std::size_t>(cell_of(voxel.offset)) + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::array<std::uint16_t, kCellsOfBlock> next;
  std::copy_n(first.begin(), next.size(), next.begin());
  for (std::size_t i = 0; i < block.occupied.size(); ++i)
    numbers[next[static_cast<std::size_t>(cell_of(block.occupied[i].offset))]++] = static_cast<std::uint16_t>(i);
}

/// Extracts the bits of the voxels of one cell from the bits of its block. Four voxels along x lie side by side in
/// both.
std::uint64_t bits_of_cell(const occupancy::VoxelBits& bits, int cell) {
  std::uint64_t out = 0;
  for (int row = 0; row < kVoxelsOfCell / kCellSide; ++row) {
    const int offset = offset_of(cell, kCellSide * row);
    out |= ((bits[static_cast<std::size_t>(offset >> 6)] >> (offset & 63)) & 15u) << (kCellSide * row);
  }
  return out;
}

/// Extracts the states of one cell from those of its block. Four voxels along x with two bits each form a byte both in
/// the block and in the cell, so bytes are copied: the rows of a cell are 4 bytes apart along y and 64 along z.
CellStates states_of_cell(const ContentBlock& block, int cell) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(block.states.words.data());
  const std::uint8_t* from = bytes + offset_of(cell, 0) / 4;
  std::array<std::uint8_t, 16> moved;
  for (std::size_t row = 0; row < moved.size(); ++row) moved[row] = from[(row & 3) * 4 + (row >> 2) * 64];
  std::array<std::uint64_t, 2> states;
  std::memcpy(states.data(), moved.data(), moved.size());
  return {bit_of_each(states, 0), bit_of_each(states, 1), bits_of_cell(block.observed_free, cell)};
}

void add_block(const ContentBlock& block, VoxelsByCell* voxels, BlockStatesBuilder* states, VoxelPoints* points) {
  voxels->sort(block);
  states->begin_block(block.index);
  for (int cell = 0; cell < kCellsOfBlock; ++cell) {
    const CellStates cell_states = states_of_cell(block, cell);
    const std::size_t begin = voxels->first[static_cast<std::size_t>(cell)];
    const std::size_t end = voxels->first[static_cast<std::size_t>(cell) + 1];
    if (kernels::count_bits(cell_states.occupied) != end - begin) fail_mismatch();
    states->add_cell(cell, cell_states);
    for (std::size_t i = begin; i < end; ++i) {
      const OccupiedVoxel& voxel = block.occupied[voxels->numbers[i]];
      points->add(is_outside(voxel.believed) || is_outside(voxel.observed) ? clamped(voxel) : voxel);
    }
  }
}

void add_distances(const std::vector<float>& distances, MeasuredDistances* out) {
  out->begin_block();
  for (int cell = 0; cell < kCellsOfBlock; ++cell) {
    MeasuredDistances::Cell codes;
    bool any = false;
    for (int voxel = 0; voxel < kVoxelsOfCell; ++voxel) {
      const std::int8_t code = out->code_of(distances[static_cast<std::size_t>(offset_of(cell, voxel))]);
      codes[static_cast<std::size_t>(voxel)] = code;
      any |= code != MeasuredDistances::kNone;
    }
    if (any) out->add_cell(cell, codes);
  }
}

/// Returns the positions of the blocks that are not empty, by rising index.
std::vector<std::size_t> order_of(const std::vector<ContentBlock>& blocks) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!blocks[i].states.all_unknown() || !blocks[i].occupied.empty()) out.push_back(i);
  }
  std::sort(out.begin(), out.end(), [&](std::size_t a, std::size_t b) { return blocks[a].index < blocks[b].index; });
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (i > 0 && blocks[out[i - 1]].index == blocks[out[i]].index)
      throw std::invalid_argument("map content has the same block twice");
    if (!is_block_in_range(blocks[out[i]].index))
      throw std::invalid_argument("map content has a block index out of range");
  }
  return out;
}

}  // namespace

SubmapContent make_content(const occupancy::MapContent& content, double band,
                           const std::vector<std::vector<float>>* distances) {
  const std::vector<std::size_t> order = order_of(content.blocks);
  BlockStatesBuilder states;
  states.reserve(order.size());
  VoxelPoints points;
  points.reserve(content.num_occupied());
  std::optional<MeasuredDistances> measured;
  if (distances) measured.emplace(band);
  VoxelsByCell voxels;
  for (const std::size_t i : order) {
    add_block(content.blocks[i], &voxels, &states, &points);
    if (measured) add_distances((*distances)[i], &*measured);
  }
  points.finish();
  if (measured) measured->finish();
  return {states.finish(), std::move(points), std::move(measured), band};
}

}  // namespace voxnav::submap
