// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/compressed_field.hpp"

#include <algorithm>
#include <cmath>

#include "voxnav/base/check.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::Vec3;

State state_in(const std::array<std::uint64_t, 2>& states, int voxel) {
  return static_cast<State>((states[voxel >> 5] >> (2 * (voxel & 31))) & 3u);
}

bool is_all_free(const containers::StateBlock& states) {
  return std::all_of(states.words.begin(), states.words.end(),
                     [](std::uint64_t w) { return w == 0x5555555555555555ull; });
}

/// Rounds -127 to 127 without a call.
std::int8_t rounded(double value) { return static_cast<std::int8_t>(static_cast<int>(value + 128.5) - 128); }

/// Squared distance from p to the cube of `side` voxels that starts at `lower`; nearest point of it on request.
double squared_to_cube(const Vec3& p, const Index3& lower, double side, Vec3* nearest) {
  const Vec3 low(lower.x, lower.y, lower.z);
  const Vec3 on_cube = p.cwiseMax(low).cwiseMin(low + Vec3::Constant(side));
  if (nearest) *nearest = on_cube;
  return (p - on_cube).squaredNorm();
}

}  // namespace

CompressedField::CompressedField(const std::vector<FilledBlock>& blocks, double band) : band_(band) {
  for (const FilledBlock& block : blocks) {
    if (!block.states.all_unknown()) add_block(block);
  }
  blocks_.shrink_to_fit();
  states_.shrink_to_fit();
  near_.shrink_to_fit();
  leaves_.shrink_to_fit();
  link();
}

int CompressedField::count_occupied(const CellStates& states) {
  constexpr std::uint64_t kHighBits = 0xAAAAAAAAAAAAAAAAull;
  return __builtin_popcountll(states[0] & kHighBits) + __builtin_popcountll(states[1] & kHighBits);
}

void CompressedField::add_block(const FilledBlock& filled) {
  Block block;
  block.index = filled.index;
  block.first_states = static_cast<std::uint32_t>(states_.size());
  block.first_near = static_cast<std::uint32_t>(near_.size());
  if (filled.values.empty() && is_all_free(filled.states)) {
    block.codes.fill(kAllFree);
  } else {
    for (int cell = 0; cell < kCells; ++cell) add_cell(filled, cell, &block);
  }
  blocks_.push_back(block);
}

void CompressedField::add_cell(const FilledBlock& filled, int cell, Block* block) {
  NearCell near{};
  bool has_value = false;
  std::array<int, 3> counts{};
  for (int voxel = 0; voxel < kCells; ++voxel) {
    const int offset = offset_of(cell, voxel);
    const State state = filled.states.get(offset);
    ++counts[static_cast<std::size_t>(state)];
    near.states[voxel >> 5] |= static_cast<std::uint64_t>(state) << (2 * (voxel & 31));
    near.values[voxel] = kNoValue;
    const float value = filled.values.empty() ? std::nanf("") : filled.values[offset];
    if (!(value <= band_)) continue;
    near.values[voxel] = rounded(std::max(-1.0, value / band_) * 127.0);
    has_value = true;
  }
  if (has_value || counts[2] > 0) {
    block->codes[cell] = static_cast<std::uint8_t>(kFirstNear + near_.size() - block->first_near);
    near_.push_back(near);
    if (counts[2] > 0) add_leaves(filled, cell);
  } else if (counts[1] == kCells) {
    block->codes[cell] = kAllFree;
  } else if (counts[1] > 0) {
    block->codes[cell] = static_cast<std::uint8_t>(kFirstStates + states_.size() - block->first_states);
    states_.push_back(near.states);
  }
}

/// Leaves of one cell, in the order of its voxels, which is also the order of their offsets.
void CompressedField::add_leaves(const FilledBlock& filled, int cell) {
  const auto before = [](const FilledLeaf& leaf, int offset) { return leaf.offset < offset; };
  auto leaf = filled.leaves.begin();
  for (int voxel = 0; voxel < kCells; ++voxel) {
    const int offset = offset_of(cell, voxel);
    if (filled.states.get(offset) != State::kOccupied) continue;
    leaf = std::lower_bound(leaf, filled.leaves.end(), offset, before);
    VOXNAV_CHECK(leaf != filled.leaves.end() && leaf->offset == offset, "an occupied voxel has no leaf");
    leaves_.push_back({leaf->mean, leaf->hits});
  }
}

void CompressedField::link() {
  std::uint32_t leaf = 0;
  for (NearCell& near : near_) {
    near.first_leaf = leaf;
    leaf += static_cast<std::uint32_t>(count_occupied(near.states));
  }
  std::size_t size = 16;
  while (size < 2 * blocks_.size()) size *= 2;
  table_.assign(size, -1);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    Block& block = blocks_[i];
    block.occupied_cells = 0;
    for (int cell = 0; cell < kCells; ++cell) {
      if (block.codes[cell] < kFirstNear) continue;
      const NearCell& near = near_[block.first_near + block.codes[cell] - kFirstNear];
      if (count_occupied(near.states) > 0) block.occupied_cells |= std::uint64_t{1} << cell;
    }
    std::size_t slot = geometry::Index3Hash{}(block.index) & (size - 1);
    while (table_[slot] >= 0) slot = (slot + 1) & (size - 1);
    table_[slot] = static_cast<std::int32_t>(i);
  }
}

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
    CellStates states{0x5555555555555555ull, 0x5555555555555555ull};
    if (code >= kFirstNear) {
      states = near_[block.first_near + code - kFirstNear].states;
    } else if (code >= kFirstStates) {
      states = states_[block.first_states + code - kFirstStates];
    }
    // A word holds two layers of sixteen voxels, two bits each.
    const int first = offset_of(cell, 0);
    const int z = first >> 8;
    for (int xy = 0; xy < 16; ++xy) {
      const std::uint64_t low = states[0] >> (2 * xy);
      const std::uint64_t high = states[1] >> (2 * xy);
      const auto column = static_cast<std::size_t>(first & 255) + static_cast<std::size_t>((xy & 3) | ((xy >> 2) << 4));
      const auto nibble = [&](int bit) {
        return static_cast<unsigned>(((low >> bit) & 1) | (((low >> (32 + bit)) & 1) << 1) |
                                     (((high >> bit) & 1) << 2) | (((high >> (32 + bit)) & 1) << 3));
      };
      out.free[column] |= static_cast<std::uint16_t>(nibble(0) << z);
      out.occupied[column] |= static_cast<std::uint16_t>(nibble(1) << z);
    }
  }
  return out;
}

State CompressedField::state(const Index3& voxel) const {
  const Block* block = find(geometry::block_of(voxel));
  return block ? state_in_block(*block, geometry::offset_in_block(voxel)) : State::kUnknown;
}

State CompressedField::Reader::state(const Index3& voxel) {
  const Index3 index = geometry::block_of(voxel);
  if (index != at_) {
    block_ = field_->find(index);
    at_ = index;
  }
  if (!block_) return State::kUnknown;
  return field_->state_in_block(*static_cast<const Block*>(block_), geometry::offset_in_block(voxel));
}

State CompressedField::state_in_block(const Block& block, int offset) const {
  const std::uint8_t code = block.codes[cell_of(offset)];
  if (code == kAllUnknown) return State::kUnknown;
  if (code == kAllFree) return State::kFree;
  const CellStates& states = code < kFirstNear ? states_[block.first_states + code - kFirstStates]
                                               : near_[block.first_near + code - kFirstNear].states;
  return state_in(states, voxel_in_cell(offset));
}

std::int8_t CompressedField::code_at(const Block& block, int offset) const {
  const std::uint8_t code = block.codes[cell_of(offset)];
  if (code < kFirstNear) return kNoValue;
  return near_[block.first_near + code - kFirstNear].values[voxel_in_cell(offset)];
}

bool CompressedField::corners(const Index3& lower, std::array<float, 8>* values) const {
  const Block* block = find(geometry::block_of(lower));
  Index3 at = geometry::block_of(lower);
  const float scale = static_cast<float>(band_ / 127.0);
  for (int corner = 0; corner < 8; ++corner) {
    const Index3 voxel = lower + Index3{corner & 1, (corner >> 1) & 1, corner >> 2};
    const Index3 index = geometry::block_of(voxel);
    if (index != at) {
      block = find(index);
      at = index;
    }
    if (!block) return false;
    const std::int8_t code = code_at(*block, geometry::offset_in_block(voxel));
    if (code == kNoValue) return false;
    (*values)[corner] = static_cast<float>(code) * scale;
  }
  return true;
}

std::optional<float> CompressedField::value(const Index3& voxel) const {
  const Block* block = find(geometry::block_of(voxel));
  if (!block) return std::nullopt;
  const std::int8_t code = code_at(*block, geometry::offset_in_block(voxel));
  if (code == kNoValue) return std::nullopt;
  return static_cast<float>(code * band_ / 127.0);
}

void CompressedField::search_block(const Block& block, const Vec3& p, Target target, Nearest* best) const {
  constexpr double kCellSide = 4.0;
  for (std::uint64_t cells = block.occupied_cells; cells != 0; cells &= cells - 1) {
    const int cell = __builtin_ctzll(cells);
    if (squared_to_cube(p, geometry::voxel_at(block.index, offset_of(cell, 0)), kCellSide, nullptr) >= best->squared)
      continue;
    const NearCell& near = near_[block.first_near + block.codes[cell] - kFirstNear];
    std::uint32_t leaf = near.first_leaf;
    for (int word = 0; word < 2; ++word) {
      for (std::uint64_t occupied = near.states[word] & 0xAAAAAAAAAAAAAAAAull; occupied != 0;
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
    for (int z = -shell; z <= shell; ++z) {
      for (int y = -shell; y <= shell; ++y) {
        const bool is_side = std::abs(z) == shell || std::abs(y) == shell;
        for (int x = -shell; x <= shell; x += is_side || shell == 0 ? 1 : 2 * shell) {
          const Index3 index = center + Index3{x, y, z};
          if (squared_to_cube(p, geometry::voxel_at(index, 0), geometry::kBlockSide, nullptr) >= best.squared) continue;
          const Block* block = find(index);
          if (block && block->occupied_cells) search_block(*block, p, target, &best);
        }
      }
    }
  }
  if (best.squared >= limit) return std::nullopt;
  return best;
}

std::size_t CompressedField::memory_bytes() const {
  return sizeof(*this) + blocks_.capacity() * sizeof(Block) + states_.capacity() * sizeof(CellStates) +
         near_.capacity() * sizeof(NearCell) + leaves_.capacity() * sizeof(Leaf) +
         table_.capacity() * sizeof(std::int32_t);
}

}  // namespace voxnav::submap
