// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/compressed_field.hpp"

namespace voxnav::submap {

using geometry::Index3;

void CompressedField::write(base::ByteWriter* out) const {
  out->put(band_);
  out->put<std::uint64_t>(blocks_.size());
  for (const Block& block : blocks_) {
    out->put(block.index);
    out->put(block.codes);
  }
  out->put<std::uint64_t>(states_.size());
  out->put_raw(states_.data(), states_.size() * sizeof(CellStates));
  out->put<std::uint64_t>(near_.size());
  out->put_raw(near_.data(), near_.size() * sizeof(CellStates));
  out->put<std::uint8_t>(has_values_);
  out->put_raw(values_.data(), values_.size() * sizeof(CellValues));
  out->put<std::uint64_t>(leaves_.size());
  out->put_raw(leaves_.data(), leaves_.size() * sizeof(Leaf));
  out->put<std::uint64_t>(own_leaves_.size());
  out->put_raw(own_leaves_.data(), own_leaves_.size() * sizeof(Leaf));
  out->put_raw(own_times_.data(), own_times_.size());
  out->put_raw(own_bits_.data(), own_bits_.size() * sizeof(std::uint64_t));
  write_own_free(out);
}

/// Gives each block its first records; they are used in order, each once.
void CompressedField::place_records(const base::ByteReader& in) {
  std::uint32_t next_states = 0;
  std::uint32_t next_near = 0;
  for (Block& block : blocks_) {
    block.first_states = next_states;
    block.first_near = next_near;
    for (const std::uint8_t code : block.codes) {
      if (code >= kEndCode) in.fail("has a cell of no kind");
      if (code >= kFirstNear) {
        if (code - kFirstNear != static_cast<int>(next_near - block.first_near)) in.fail("has cells out of order");
        ++next_near;
      } else if (code >= kFirstStates) {
        if (code - kFirstStates != static_cast<int>(next_states - block.first_states))
          in.fail("has cells out of order");
        ++next_states;
      }
    }
  }
  if (next_states != states_.size() || next_near != near_.size()) in.fail("has cells that do not match its blocks");
}

CompressedField CompressedField::read(base::ByteReader* in, OwnParts own) {
  CompressedField field;
  constexpr double kWidestBand = 6.0;  // as SubmapConfig allows: the windows that distances are derived in hold no more
  field.band_ = in->get<double>();
  if (!(field.band_ >= 1.0 && field.band_ <= kWidestBand)) in->fail("has no usable distance band");
  field.blocks_.resize(in->get_count(sizeof(Index3) + kCells));
  for (Block& block : field.blocks_) {
    block.index = in->get<Index3>();
    in->get_raw(block.codes.data(), block.codes.size());
  }
  field.states_.resize(in->get_count(sizeof(CellStates)));
  in->get_raw(field.states_.data(), field.states_.size() * sizeof(CellStates));
  field.near_.resize(in->get_count(sizeof(CellStates)));
  in->get_raw(field.near_.data(), field.near_.size() * sizeof(CellStates));
  const auto has_values = in->get<std::uint8_t>();
  if (has_values > 1) in->fail("does not say whether it holds distances");
  field.has_values_ = has_values == 1;
  if (field.has_values_) {
    if (field.near_.size() > in->remaining() / sizeof(CellValues)) in->fail("ends before its distances");
    field.values_.resize(field.near_.size());
    in->get_raw(field.values_.data(), field.values_.size() * sizeof(CellValues));
  }
  std::vector<Leaf> leaves(in->get_count(sizeof(Leaf)));
  in->get_raw(leaves.data(), leaves.size() * sizeof(Leaf));
  if (own != OwnParts::kNone || field.has_values_) {
    field.leaves_ = std::move(leaves);
  } else {
    for (const Leaf& leaf : leaves) field.add_leaf(leaf, leaf, kUnknownTime);
  }
  if (own != OwnParts::kNone) field.read_own(in);
  field.place_records(*in);
  field.check(*in);
  if (own == OwnParts::kHitsAndFree) {
    field.read_own_free(in);
  } else {
    field.take_all_free();
  }
  field.link();
  return field;
}

void CompressedField::check(const base::ByteReader& in) const {
  constexpr std::int32_t kLimit = 1 << 26;
  std::size_t num_occupied = 0;
  for (const CellStates& states : states_) {
    if (((states[0] | states[1]) & 0xAAAAAAAAAAAAAAAAull) != 0) in.fail("has an occupied voxel without surface");
  }
  for (const CellStates& near : near_) {
    for (const std::uint64_t word : near) {
      if (word & (word >> 1) & 0x5555555555555555ull) in.fail("holds a voxel state that does not exist");
    }
    num_occupied += static_cast<std::size_t>(count_occupied(near));
  }
  if (num_occupied != leaves_.size()) in.fail("has leaves that do not match its states");
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Index3& b = blocks_[i].index;
    for (const std::int32_t c : {b.x, b.y, b.z}) {
      if (c < -kLimit || c >= kLimit) in.fail("has a block index out of range");
    }
    if (i > 0 && !(blocks_[i - 1].index < b)) in.fail("has unsorted blocks");
  }
}

}  // namespace voxnav::submap
