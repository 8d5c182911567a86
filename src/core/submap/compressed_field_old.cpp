// SPDX-License-Identifier: BSD-3-Clause
// Fields as versions 2 to 4 of submaps kept them: a code per cell, two bits per voxel, every own leaf.
#include "cell_bits.hpp"
#include "submap/compressed_field.hpp"

namespace voxnav::submap {
namespace {

constexpr std::uint32_t kWithoutOwn = 2;      // what a submap saw itself was not told from what it remembered
constexpr std::uint32_t kWithoutOwnFree = 3;  // neither was its free space
constexpr int kCellsOfBlock = 64;
constexpr std::uint8_t kAllFree = 1;
constexpr std::uint8_t kFirstStates = 2;                // code - kFirstStates: states record of the block
constexpr std::uint8_t kFirstNear = 2 + kCellsOfBlock;  // code - kFirstNear: near record of the block
constexpr std::uint8_t kEndCode = 2 + 2 * kCellsOfBlock;

using Codes = std::array<std::uint8_t, kCellsOfBlock>;
using States = std::array<std::uint64_t, 2>;

/// Records are used in order, each once.
class Records {
 public:
  Records(base::ByteReader* in, const char* wrong) : in_(in), wrong_(wrong) {
    states_.resize(in->get_count(sizeof(States)));
    in->get_raw(states_.data(), states_.size() * sizeof(States));
  }
  std::size_t size() const { return states_.size(); }
  std::size_t num_used() const { return next_; }
  void enter_block() { first_ = next_; }
  const States& take(int number) {
    if (number != static_cast<int>(next_ - first_)) in_->fail("has cells out of order");
    if (next_ == states_.size()) in_->fail("has cells that do not match its blocks");
    const States& states = states_[next_++];
    if ((bit_of_each(states, 0) & bit_of_each(states, 1)) != 0) in_->fail("holds a voxel state that does not exist");
    if (wrong_ && bit_of_each(states, 1) != 0) in_->fail(wrong_);
    return states;
  }

 private:
  base::ByteReader* in_;
  const char* wrong_;  ///< null: voxels may be occupied
  std::vector<States> states_;
  std::size_t next_ = 0, first_ = 0;
};

}  // namespace

void CompressedField::read_old(base::ByteReader* in, std::uint32_t version) {
  std::vector<Codes> codes(in->get_count(sizeof(geometry::Index3) + sizeof(Codes)));
  std::vector<geometry::Index3> indices(codes.size());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    indices[i] = in->get<geometry::Index3>();
    codes[i] = in->get<Codes>();
  }
  Records states(in, "has an occupied voxel without surface"), near(in, nullptr);
  const auto has_values = in->get<std::uint8_t>();
  if (has_values > 1) in->fail("does not say whether it holds distances");
  has_values_ = has_values == 1;
  std::vector<CellValues> values(has_values_ ? near.size() : 0);
  if (values.size() > in->remaining() / sizeof(CellValues)) in->fail("ends before its distances");
  in->get_raw(values.data(), values.size() * sizeof(CellValues));
  for (std::size_t i = 0; i < codes.size(); ++i) {
    Block block = new_block(indices[i]);
    states.enter_block();
    near.enter_block();
    for (int cell = 0; cell < kCells; ++cell) {
      const std::uint8_t code = codes[i][static_cast<std::size_t>(cell)];
      if (code >= kEndCode) in->fail("has a cell of no kind");
      if (code >= kFirstNear) {
        const CellValues* value = has_values_ ? &values[near.num_used()] : nullptr;
        const States& cell_states = near.take(code - kFirstNear);
        add_cell(cell, bit_of_each(cell_states, 0), bit_of_each(cell_states, 1), value, &block);
      } else if (code >= kFirstStates) {
        add_cell(cell, bit_of_each(states.take(code - kFirstStates), 0), 0, nullptr, &block);
      } else if (code == kAllFree) {
        add_cell(cell, ~std::uint64_t{0}, 0, nullptr, &block);
      }
    }
    blocks_.push_back(block);
  }
  if (states.num_used() != states.size() || near.num_used() != near.size())
    in->fail("has cells that do not match its blocks");
  read_old_leaves(in, version);
  read_old_own_free(in, version);
}

/// One bit per leaf says whether it has an own one too.
void CompressedField::read_old_leaves(base::ByteReader* in, std::uint32_t version) {
  std::vector<Leaf> leaves(in->get_count(sizeof(Leaf)));
  in->get_raw(leaves.data(), leaves.size() * sizeof(Leaf));
  std::vector<Leaf> own(version == kWithoutOwn ? 0 : in->get_count(sizeof(Leaf) + 1));
  in->get_raw(own.data(), own.size() * sizeof(Leaf));
  std::vector<std::uint8_t> times(own.size());
  in->get_raw(times.data(), times.size());
  if (has_values_ && !own.empty()) in->fail("has own hits beside measured distances");
  std::vector<std::uint64_t> bits(version == kWithoutOwn || has_values_ ? 0 : (leaves.size() + 63) / 64);
  in->get_raw(bits.data(), bits.size() * sizeof(std::uint64_t));
  std::size_t num_own = 0;
  for (const std::uint64_t word : bits) num_own += occupancy::count_bits(word);
  const bool is_beyond = !bits.empty() && leaves.size() % 64 != 0 && (bits.back() >> (leaves.size() % 64)) != 0;
  if (is_beyond || num_own != own.size()) in->fail("has own hits that do not match its leaves");
  if (has_values_) {
    leaves_ = std::move(leaves);
    return;
  }
  std::size_t next = 0;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    if (version == kWithoutOwn) {
      add_leaf(leaves[i], leaves[i], kUnknownTime);
    } else if ((bits[i >> 6] >> (i & 63)) & 1) {
      add_leaf(leaves[i], own[next], times[next]);
      ++next;
    } else {
      add_leaf(leaves[i], Leaf{{}, 0}, 0);
    }
  }
}

void CompressedField::read_old_own_free(base::ByteReader* in, std::uint32_t version) {
  for (Block& block : blocks_) {
    if (version <= kWithoutOwnFree) {
      for (int cell = 0; cell < kCells && !has_values_; ++cell) {
        if (free_of(block, cell) != 0) block.own_cells |= std::uint64_t{1} << cell;
      }
      continue;
    }
    block.own_cells = in->get<std::uint64_t>();
    block.partly_own_cells = in->get<std::uint64_t>();
  }
  if (version <= kWithoutOwnFree) return;
  own_free_.resize(in->get_count(sizeof(std::uint64_t)));
  in->get_raw(own_free_.data(), own_free_.size() * sizeof(std::uint64_t));
  std::size_t next = 0;
  for (Block& block : blocks_) {
    block.first_own_free = static_cast<std::uint32_t>(next);
    next += occupancy::count_bits(block.partly_own_cells);
  }
}

}  // namespace voxnav::submap
