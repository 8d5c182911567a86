// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/compressed_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "voxnav/base/check.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::Vec3;

State state_in(const std::array<std::uint64_t, 2>& states, int voxel) {
  return static_cast<State>((states[voxel >> 5] >> (2 * (voxel & 31))) & 3u);
}

/// Rounds -127 to 127 without a call.
std::int8_t rounded(double value) { return static_cast<std::int8_t>(static_cast<int>(value + 128.5) - 128); }

/// Leaves of a block cell by cell, in the order of their voxels, which is also that of their offsets.
std::array<std::vector<CompressedField::Leaf>, 64> leaves_by_cell(const occupancy::ContentBlock& block) {
  std::array<std::vector<CompressedField::Leaf>, 64> out;
  int last = -1;
  for (const occupancy::OccupiedLeaf& leaf : block.occupied) {
    const bool fits =
        leaf.offset < geometry::kBlockVolume && leaf.offset > last && block.states.get(leaf.offset) == State::kOccupied;
    if (!fits) throw std::invalid_argument("map content has leaves that do not match its states");
    last = leaf.offset;
    std::array<std::int8_t, 3> mean;
    for (std::size_t k = 0; k < 3; ++k) mean[k] = std::max<std::int8_t>(leaf.mean[k], -127);
    out[static_cast<std::size_t>(CompressedField::cell_of(leaf.offset))].push_back({mean, leaf.hits});
  }
  return out;
}

/// Squared distance from p to the cube of `side` voxels that starts at `lower`; nearest point of it on request.
double squared_to_cube(const Vec3& p, const Index3& lower, double side, Vec3* nearest) {
  const Vec3 low(lower.x, lower.y, lower.z);
  const Vec3 on_cube = p.cwiseMax(low).cwiseMin(low + Vec3::Constant(side));
  if (nearest) *nearest = on_cube;
  return (p - on_cube).squaredNorm();
}

}  // namespace

CompressedField::CompressedField(const occupancy::MapContent& content, double band) : band_(band) {
  std::vector<const occupancy::ContentBlock*> order;
  for (const occupancy::ContentBlock& block : content.blocks) {
    if (!block.states.all_unknown() || !block.occupied.empty()) order.push_back(&block);
  }
  std::sort(order.begin(), order.end(), [](const auto* a, const auto* b) { return a->index < b->index; });
  blocks_.reserve(order.size());
  leaves_.reserve(content.num_occupied());
  for (const occupancy::ContentBlock* block : order) {
    if (!blocks_.empty() && blocks_.back().index == block->index)
      throw std::invalid_argument("map content has the same block twice");
    add_block(*block);
  }
  shrink();
  link();
}

CompressedField::CompressedField(const std::vector<FilledBlock>& blocks, double band) : band_(band), has_values_(true) {
  for (const FilledBlock& block : blocks) {
    if (!block.states.all_unknown()) add_block(block);
  }
  shrink();
  link();
}

void CompressedField::shrink() {
  blocks_.shrink_to_fit();
  states_.shrink_to_fit();
  near_.shrink_to_fit();
  values_.shrink_to_fit();
  leaves_.shrink_to_fit();
}

int CompressedField::count_occupied(const CellStates& states) {
  constexpr std::uint64_t kHighBits = 0xAAAAAAAAAAAAAAAAull;
  return __builtin_popcountll(states[0] & kHighBits) + __builtin_popcountll(states[1] & kHighBits);
}

CompressedField::Block CompressedField::new_block(const Index3& index) const {
  Block block;
  block.index = index;
  block.first_states = static_cast<std::uint32_t>(states_.size());
  block.first_near = static_cast<std::uint32_t>(near_.size());
  return block;
}

/// A byte holds four voxels along x, in a block and in a cell, so that states move byte by byte.
void CompressedField::add_block(const occupancy::ContentBlock& content) {
  Block block = new_block(content.index);
  std::array<std::uint8_t, geometry::kBlockVolume / 4> bytes;
  std::memcpy(bytes.data(), content.states.words.data(), bytes.size());
  std::array<std::vector<Leaf>, kCells> by_cell = leaves_by_cell(content);
  for (int cell = 0; cell < kCells; ++cell) {
    std::array<std::uint8_t, 16> moved;
    const std::uint8_t* from = &bytes[static_cast<std::size_t>(offset_of(cell, 0) / 4)];
    for (std::size_t row = 0; row < moved.size(); ++row) moved[row] = from[(row & 3) * 4 + (row >> 2) * 64];
    CellStates states;
    std::memcpy(states.data(), moved.data(), moved.size());
    const std::vector<Leaf>& leaves = by_cell[static_cast<std::size_t>(cell)];
    if (count_occupied(states) != static_cast<int>(leaves.size()))
      throw std::invalid_argument("map content has leaves that do not match its states");
    add_cell(cell, states, nullptr, &block);
    leaves_.insert(leaves_.end(), leaves.begin(), leaves.end());
  }
  blocks_.push_back(block);
}

void CompressedField::add_block(const FilledBlock& filled) {
  Block block = new_block(filled.index);
  auto leaf = filled.leaves.begin();
  for (int cell = 0; cell < kCells; ++cell) {
    CellStates states{};
    CellValues values;
    values.fill(kNoValue);
    bool has_value = false;
    const std::size_t first_leaf = leaves_.size();
    for (int voxel = 0; voxel < kCells; ++voxel) {
      const int offset = offset_of(cell, voxel);
      const State state = filled.states.get(offset);
      states[voxel >> 5] |= static_cast<std::uint64_t>(state) << (2 * (voxel & 31));
      const float value = filled.values.empty() ? std::nanf("") : filled.values[static_cast<std::size_t>(offset)];
      if (value <= band_) values[voxel] = rounded(std::max(-1.0, value / band_) * 127.0);
      has_value |= value <= band_;
      if (state != State::kOccupied) continue;
      leaf = std::lower_bound(filled.leaves.begin(), filled.leaves.end(), offset,
                              [](const FilledLeaf& l, int o) { return l.offset < o; });
      VOXNAV_CHECK(leaf != filled.leaves.end() && leaf->offset == offset, "an occupied voxel has no leaf");
      leaves_.push_back({leaf->mean, leaf->hits});
    }
    add_cell(cell, states, has_value || leaves_.size() > first_leaf ? &values : nullptr, &block);
  }
  blocks_.push_back(block);
}

void CompressedField::add_cell(int cell, const CellStates& states, const CellValues* values, Block* block) {
  constexpr std::uint64_t kAllFreeWord = 0x5555555555555555ull;
  if (values || count_occupied(states) > 0) {
    block->codes[cell] = static_cast<std::uint8_t>(kFirstNear + block->num_near++);
    near_.push_back(states);
    if (values) values_.push_back(*values);
  } else if (states[0] == kAllFreeWord && states[1] == kAllFreeWord) {
    block->codes[cell] = kAllFree;
  } else if ((states[0] | states[1]) != 0) {
    block->codes[cell] = static_cast<std::uint8_t>(kFirstStates + states_.size() - block->first_states);
    states_.push_back(states);
  }
}

void CompressedField::link() {
  std::uint32_t leaf = 0;
  first_leaf_.clear();
  first_leaf_.reserve(near_.size());
  for (const CellStates& near : near_) {
    first_leaf_.push_back(leaf);
    leaf += static_cast<std::uint32_t>(count_occupied(near));
  }
  std::size_t size = 16;
  while (size < 2 * blocks_.size()) size *= 2;
  table_.assign(size, -1);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    Block& block = blocks_[i];
    block.occupied_cells = 0;
    block.num_near = 0;
    for (int cell = 0; cell < kCells; ++cell) {
      if (block.codes[cell] < kFirstNear) continue;
      ++block.num_near;
      const CellStates& near = near_[block.first_near + block.codes[cell] - kFirstNear];
      if (count_occupied(near) > 0) block.occupied_cells |= std::uint64_t{1} << cell;
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
    const CellStates states = cell_states(block, cell);
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
         near_.capacity() * sizeof(CellStates) + first_leaf_.capacity() * sizeof(std::uint32_t) +
         values_.capacity() * sizeof(CellValues) + leaves_.capacity() * sizeof(Leaf) +
         table_.capacity() * sizeof(std::int32_t);
}

}  // namespace voxnav::submap
