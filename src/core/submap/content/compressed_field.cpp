// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/compressed_field.hpp"

#include <cmath>
#include <cstring>

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::Vec3;

/// Moves bit i to bit 4 i.
std::uint64_t spread_by_four(std::uint64_t bits) {
  bits = (bits | (bits << 24)) & 0x000000FF000000FFull;
  bits = (bits | (bits << 12)) & 0x000F000F000F000Full;
  bits = (bits | (bits << 6)) & 0x0303030303030303ull;
  return (bits | (bits << 3)) & 0x1111111111111111ull;
}

/// A bit per voxel of a cell as columns of four, x fastest: it comes in four layers of 16 voxels.
std::uint64_t columns_of_cell(std::uint64_t bits) {
  return spread_by_four(bits & 0xFFFFu) | spread_by_four((bits >> 16) & 0xFFFFu) << 1 |
         spread_by_four((bits >> 32) & 0xFFFFu) << 2 | spread_by_four(bits >> 48) << 3;
}

/// Columns of four of a cell into those of its block, four at once. @param columns  of the block, from the cell's first
/// on
void add_nibbles(std::uint64_t nibbles, int z, std::uint16_t* columns) {
  for (int y = 0; y < 4; ++y, columns += geometry::kBlockSide, nibbles >>= 16) {
    const std::uint64_t apart =
        (nibbles & 0xFu) | (nibbles & 0xF0u) << 12 | (nibbles & 0xF00u) << 24 | (nibbles & 0xF000u) << 36;
    std::uint64_t four;
    std::memcpy(&four, columns, sizeof four);
    four |= apart << z;
    std::memcpy(columns, &four, sizeof four);
  }
}

/// Squared distance from p to the cube of `side` voxels that starts at `lower`; nearest point of it on request.
double squared_to_cube(const Vec3& p, const Index3& lower, double side, Vec3* nearest) {
  const Vec3 low(lower.x, lower.y, lower.z);
  const Vec3 on_cube = p.cwiseMax(low).cwiseMin(low + Vec3::Constant(side));
  if (nearest) *nearest = on_cube;
  return (p - on_cube).squaredNorm();
}

}  // namespace

int CompressedField::position_of(const Index3& index) const {
  if (table_.empty()) return -1;
  const std::size_t mask = table_.size() - 1;
  for (std::size_t slot = geometry::Index3Hash{}(index)&mask; table_[slot] >= 0; slot = (slot + 1) & mask) {
    if (blocks_[static_cast<std::size_t>(table_[slot])].index == index) return table_[slot];
  }
  return -1;
}

const CompressedField::Block* CompressedField::find(const Index3& index) const {
  const int position = position_of(index);
  return position < 0 ? nullptr : &blocks_[static_cast<std::size_t>(position)];
}

ColumnBlock CompressedField::columns(std::size_t i) const {
  const Block& block = blocks_[i];
  ColumnBlock out;
  for (std::uint64_t cells = block.near_cells | block.open_cells | block.mixed_cells; cells != 0; cells &= cells - 1) {
    const int cell = __builtin_ctzll(cells);
    const int first = offset_of(cell, 0);
    const auto column = static_cast<std::size_t>(first & 255);
    add_nibbles(columns_of_cell(free_of(block, cell)), first >> 8, &out.free[column]);
    if (has(block.near_cells, cell))
      add_nibbles(columns_of_cell(occupied_of(block, cell)), first >> 8, &out.occupied[column]);
  }
  return out;
}

Columns CompressedField::own_free(std::size_t i) const {
  if (has_values_) return columns(i).free;
  const Block& block = blocks_[i];
  std::size_t next = block.first_own_free;
  Columns out{};
  for (std::uint64_t cells = block.own_cells | block.partly_own_cells; cells != 0; cells &= cells - 1) {
    const int cell = __builtin_ctzll(cells);
    const std::uint64_t free = has(block.own_cells, cell) ? free_of(block, cell) : own_free_[next++];
    const int first = offset_of(cell, 0);
    add_nibbles(columns_of_cell(free), first >> 8, &out[static_cast<std::size_t>(first & 255)]);
  }
  return out;
}

State CompressedField::state(const Index3& voxel) const {
  const Block* block = find(geometry::block_of(voxel));
  return block ? state_in_block(*block, geometry::offset_in_block(voxel)) : State::kUnknown;
}

State CompressedField::state_in_block(const Block& block, int offset) const {
  const int cell = cell_of(offset);
  const int voxel = voxel_in_cell(offset);
  if (has(occupied_of(block, cell), voxel)) return State::kOccupied;
  return has(free_of(block, cell), voxel) ? State::kFree : State::kUnknown;
}

std::optional<float> CompressedField::value(const Index3& voxel) const {
  const Block* block = has_values_ ? find(geometry::block_of(voxel)) : nullptr;
  if (!block) return std::nullopt;
  const int offset = geometry::offset_in_block(voxel);
  const int cell = cell_of(offset);
  if (!has(block->near_cells, cell)) return std::nullopt;
  const std::int8_t stored = values_[near_of(*block, cell)][voxel_in_cell(offset)];
  if (stored == kNoValue) return std::nullopt;
  return static_cast<float>(stored * band_ / 127.0);
}

void CompressedField::search_block(const Block& block, const Vec3& p, Target target, Nearest* best) const {
  constexpr double kCellSide = 4.0;
  std::size_t near = block.first_near;
  for (std::uint64_t cells = block.near_cells; cells != 0; cells &= cells - 1, ++near) {
    const int cell = __builtin_ctzll(cells);
    if (squared_to_cube(p, geometry::voxel_at(block.index, offset_of(cell, 0)), kCellSide, nullptr) >= best->squared)
      continue;
    std::size_t leaf = first_leaf_of(block, near);
    for (std::uint64_t occupied = occupied_[near]; occupied != 0; occupied &= occupied - 1) {
      const Index3 index = geometry::voxel_at(block.index, offset_of(cell, __builtin_ctzll(occupied)));
      Vec3 point = surface_point(index, leaves_[leaf++]);
      const double squared =
          target == Target::kSurfacePoint ? (p - point).squaredNorm() : squared_to_cube(p, index, 1.0, &point);
      if (squared < best->squared) *best = {point, squared};
    }
  }
}

void CompressedField::search_near_block(const Block& block, const Vec3& p, Target target, Nearest* best) const {
  if (block.near_cells == 0) return;
  const Index3 first = geometry::voxel_at(block.index, 0);
  if (squared_to_cube(p, first, geometry::kBlockSide, nullptr) < best->squared) search_block(block, p, target, best);
}

std::optional<CompressedField::Nearest> CompressedField::nearest(const Vec3& p, double max_distance,
                                                                 Target target) const {
  Nearest best;
  const double limit = max_distance * max_distance;
  best.squared = limit;
  const Index3 center = geometry::index_of(p, geometry::kBlockSide);
  const int last_shell = static_cast<int>(max_distance / geometry::kBlockSide) + 1;
  for (int shell = 0; shell <= last_shell; ++shell) {
    // Nothing of this shell of blocks is nearer than the blocks between.
    const double reach = (shell - 1) * static_cast<double>(geometry::kBlockSide);
    if (shell > 1 && reach * reach >= best.squared) break;
    // Where more places would be visited than there are blocks, these are looked through instead.
    if (24.0 * shell * shell > static_cast<double>(blocks_.size())) {
      for (const Block& block : blocks_) search_near_block(block, p, target, &best);
      break;
    }
    for (int z = -shell; z <= shell; ++z) {
      for (int y = -shell; y <= shell; ++y) {
        const bool is_side = std::abs(z) == shell || std::abs(y) == shell;
        for (int x = -shell; x <= shell; x += is_side || shell == 0 ? 1 : 2 * shell) {
          const Index3 index = center + Index3{x, y, z};
          if (squared_to_cube(p, geometry::voxel_at(index, 0), geometry::kBlockSide, nullptr) >= best.squared) continue;
          const Block* block = find(index);
          if (block) search_near_block(*block, p, target, &best);
        }
      }
    }
  }
  if (best.squared >= limit) return std::nullopt;
  return best;
}

std::size_t CompressedField::memory_bytes() const {
  const auto bytes = [](const auto&... vectors) { return ((vectors.capacity() * sizeof(vectors[0])) + ...); };
  return sizeof(*this) + bytes(blocks_, free_, occupied_, leaf_offsets_, values_, leaves_, own_bits_, own_before_,
                               own_times_, changed_bits_, changed_before_, own_leaves_, own_free_, table_);
}

}  // namespace voxnav::submap
