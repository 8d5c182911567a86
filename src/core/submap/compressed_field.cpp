// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/compressed_field.hpp"

#include <cmath>

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::Vec3;

State state_in(const std::array<std::uint64_t, 2>& states, int voxel) {
  return static_cast<State>((states[voxel >> 5] >> (2 * (voxel & 31))) & 3u);
}

/// Moves bit i to bit 4 i.
std::uint64_t spread_by_four(std::uint64_t bits) {
  bits = (bits | (bits << 24)) & 0x000000FF000000FFull;
  bits = (bits | (bits << 12)) & 0x000F000F000F000Full;
  bits = (bits | (bits << 6)) & 0x0303030303030303ull;
  return (bits | (bits << 3)) & 0x1111111111111111ull;
}

/// Moves bit 2 i to bit i.
std::uint64_t gather_even(std::uint64_t bits) {
  bits &= 0x5555555555555555ull;
  bits = (bits | (bits >> 1)) & 0x3333333333333333ull;
  bits = (bits | (bits >> 2)) & 0x0F0F0F0F0F0F0F0Full;
  bits = (bits | (bits >> 4)) & 0x00FF00FF00FF00FFull;
  bits = (bits | (bits >> 8)) & 0x0000FFFF0000FFFFull;
  return (bits | (bits >> 16)) & 0x00000000FFFFFFFFull;
}

/// One of the two bits of each voxel of a cell.
std::uint64_t bit_of_each(const std::array<std::uint64_t, 2>& states, int bit) {
  return gather_even(states[0] >> bit) | gather_even(states[1] >> bit) << 32;
}

/// A bit per voxel of a cell as columns of four, x fastest: it comes in four layers of 16 voxels.
std::uint64_t columns_of_cell(std::uint64_t bits) {
  return spread_by_four(bits & 0xFFFFu) | spread_by_four((bits >> 16) & 0xFFFFu) << 1 |
         spread_by_four((bits >> 32) & 0xFFFFu) << 2 | spread_by_four(bits >> 48) << 3;
}

/// Columns of four of a cell into those of its block. @param columns  of the block, from the cell's first on
void add_nibbles(std::uint64_t nibbles, int z, std::uint16_t* columns) {
  for (int y = 0; y < 4; ++y, columns += geometry::kBlockSide) {
    for (int x = 0; x < 4; ++x, nibbles >>= 4) columns[x] |= static_cast<std::uint16_t>((nibbles & 15u) << z);
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
  for (int cell = 0; cell < kCells; ++cell) {
    const std::uint8_t code = block.codes[cell];
    if (code == kAllUnknown) continue;
    const CellStates states = cell_states(block, cell);
    const int first = offset_of(cell, 0);
    std::uint16_t* free = &out.free[static_cast<std::size_t>(first & 255)];
    add_nibbles(code == kAllFree ? ~std::uint64_t{0} : columns_of_cell(free_of(states)), first >> 8, free);
    if (code < kFirstNear) continue;
    add_nibbles(columns_of_cell(bit_of_each(states, 1)), first >> 8,
                &out.occupied[static_cast<std::size_t>(first & 255)]);
  }
  return out;
}

std::uint64_t CompressedField::free_of(const CellStates& states) { return bit_of_each(states, 0); }

Columns CompressedField::own_free(std::size_t i) const {
  if (has_values_) return columns(i).free;
  const Block& block = blocks_[i];
  std::size_t next = block.first_own_free;
  Columns out{};
  for (std::uint64_t cells = block.own_cells | block.partly_own_cells; cells != 0; cells &= cells - 1) {
    const int cell = __builtin_ctzll(cells);
    const bool is_whole = (block.own_cells >> cell) & 1;
    const std::uint64_t free = is_whole ? free_of(cell_states(block, cell)) : own_free_[next++];
    const int first = offset_of(cell, 0);
    add_nibbles(columns_of_cell(free), first >> 8, &out[static_cast<std::size_t>(first & 255)]);
  }
  return out;
}

State CompressedField::state(const Index3& voxel) const {
  const Block* block = find(geometry::block_of(voxel));
  return block ? state_in_block(*block, geometry::offset_in_block(voxel)) : State::kUnknown;
}

CompressedField::CellStates CompressedField::cell_states(const Block& block, int cell) const {
  const std::uint8_t code = block.codes[cell];
  if (code >= kFirstNear) return near_[block.first_near + code - kFirstNear];
  if (code >= kFirstStates) return states_[block.first_states + code - kFirstStates];
  const std::uint64_t word = code == kAllFree ? 0x5555555555555555ull : 0;
  return {word, word};
}

State CompressedField::state_in_block(const Block& block, int offset) const {
  const std::uint8_t code = block.codes[cell_of(offset)];
  if (code == kAllUnknown) return State::kUnknown;
  if (code == kAllFree) return State::kFree;
  const CellStates& states = code < kFirstNear ? states_[block.first_states + code - kFirstStates]
                                               : near_[block.first_near + code - kFirstNear];
  return state_in(states, voxel_in_cell(offset));
}

std::optional<float> CompressedField::value(const Index3& voxel) const {
  const Block* block = has_values_ ? find(geometry::block_of(voxel)) : nullptr;
  if (!block) return std::nullopt;
  const int offset = geometry::offset_in_block(voxel);
  const std::uint8_t code = block->codes[cell_of(offset)];
  if (code < kFirstNear) return std::nullopt;
  const std::int8_t stored = values_[block->first_near + code - kFirstNear][voxel_in_cell(offset)];
  if (stored == kNoValue) return std::nullopt;
  return static_cast<float>(stored * band_ / 127.0);
}

void CompressedField::search_block(const Block& block, const Vec3& p, Target target, Nearest* best) const {
  constexpr double kCellSide = 4.0;
  for (std::uint64_t cells = block.occupied_cells; cells != 0; cells &= cells - 1) {
    const int cell = __builtin_ctzll(cells);
    if (squared_to_cube(p, geometry::voxel_at(block.index, offset_of(cell, 0)), kCellSide, nullptr) >= best->squared)
      continue;
    const std::size_t near = block.first_near + block.codes[cell] - kFirstNear;
    std::uint32_t leaf = first_leaf_[near];
    for (int word = 0; word < 2; ++word) {
      for (std::uint64_t occupied = near_[near][word] & 0xAAAAAAAAAAAAAAAAull; occupied != 0;
           occupied &= occupied - 1) {
        const int voxel = 32 * word + (__builtin_ctzll(occupied) >> 1);
        const Index3 index = geometry::voxel_at(block.index, offset_of(cell, voxel));
        Vec3 point = surface_point(index, leaves_[leaf++]);
        const double squared =
            target == Target::kSurfacePoint ? (p - point).squaredNorm() : squared_to_cube(p, index, 1.0, &point);
        if (squared < best->squared) *best = {point, squared};
      }
    }
  }
}

void CompressedField::search_near_block(const Block& block, const Vec3& p, Target target, Nearest* best) const {
  if (block.occupied_cells == 0) return;
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
  return sizeof(*this) + blocks_.capacity() * sizeof(Block) + states_.capacity() * sizeof(CellStates) +
         near_.capacity() * sizeof(CellStates) + first_leaf_.capacity() * sizeof(std::uint32_t) +
         values_.capacity() * sizeof(CellValues) + (leaves_.capacity() + own_leaves_.capacity()) * sizeof(Leaf) +
         (own_bits_.capacity() + own_free_.capacity()) * sizeof(std::uint64_t) + own_times_.capacity() +
         own_before_.capacity() * sizeof(std::uint32_t) + table_.capacity() * sizeof(std::int32_t);
}

}  // namespace voxnav::submap
