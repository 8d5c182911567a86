// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/cell_bits.hpp"
#include "submap/content/compressed_field.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;

template <class T>
void put_all(const std::vector<T>& items, base::ByteWriter* out) {
  out->put<std::uint64_t>(items.size());
  out->put_raw(items.data(), items.size() * sizeof(T));
}
template <class T>
void get_all(base::ByteReader* in, std::vector<T>* items) {
  items->resize(in->get_count(sizeof(T)));
  in->get_raw(items->data(), items->size() * sizeof(T));
}

}  // namespace

void CompressedField::write(base::ByteWriter* out) const {
  out->put(band_);
  out->put<std::uint64_t>(blocks_.size());
  for (const Block& block : blocks_) {
    out->put(block.index);
    for (const std::uint64_t cells :
         {block.near_cells, block.open_cells, block.mixed_cells, block.own_cells, block.partly_own_cells})
      out->put(cells);
  }
  put_all(occupied_, out);
  put_all(free_, out);
  out->put<std::uint8_t>(has_values_);
  out->put_raw(values_.data(), values_.size() * sizeof(CellValues));
  put_all(leaves_, out);
  put_all(own_times_, out);
  put_all(own_leaves_, out);
  out->put_raw(own_bits_.data(), own_bits_.size() * sizeof(std::uint64_t));
  out->put_raw(changed_bits_.data(), changed_bits_.size() * sizeof(std::uint64_t));
  put_all(own_free_, out);
}

CompressedField CompressedField::read(base::ByteReader* in) {
  CompressedField field;
  constexpr double kWidestBand = 6.0;  // as SubmapConfig allows: the windows that distances are derived in hold no more
  field.band_ = in->get<double>();
  if (!(field.band_ >= 1.0 && field.band_ <= kWidestBand)) in->fail("has no usable distance band");
  field.read_blocks(in);
  field.read_values(in);
  get_all(in, &field.leaves_);
  field.read_own(in);
  field.check(*in);
  field.link();
  return field;
}

/// Gives each block its first records; they are used in order, each once.
void CompressedField::read_blocks(base::ByteReader* in) {
  blocks_.resize(in->get_count(sizeof(Index3) + 5 * sizeof(std::uint64_t)));
  for (Block& block : blocks_) {
    block.index = in->get<Index3>();
    for (std::uint64_t* cells :
         {&block.near_cells, &block.open_cells, &block.mixed_cells, &block.own_cells, &block.partly_own_cells})
      *cells = in->get<std::uint64_t>();
    if ((block.open_cells & block.mixed_cells) != 0) in->fail("has cells that are free both in part and as a whole");
  }
  get_all(in, &occupied_);
  get_all(in, &free_);
  std::size_t near = 0, free = 0, own_free = 0;
  for (Block& block : blocks_) {
    block.first_near = static_cast<std::uint32_t>(near);
    block.first_free = static_cast<std::uint32_t>(free);
    block.first_own_free = static_cast<std::uint32_t>(own_free);
    near += kernels::count_bits(block.near_cells);
    free += kernels::count_bits(block.mixed_cells);
    own_free += kernels::count_bits(block.partly_own_cells);
  }
  if (near != occupied_.size() || free != free_.size()) in->fail("has cells that do not match its blocks");
}

void CompressedField::read_values(base::ByteReader* in) {
  const auto has_values = in->get<std::uint8_t>();
  if (has_values > 1) in->fail("does not say whether it holds distances");
  has_values_ = has_values == 1;
  if (!has_values_) return;
  if (occupied_.size() > in->remaining() / sizeof(CellValues)) in->fail("ends before its distances");
  values_.resize(occupied_.size());
  in->get_raw(values_.data(), values_.size() * sizeof(CellValues));
}

/// Bits say which leaves have an own one too, and which of these another one.
void CompressedField::read_own(base::ByteReader* in) {
  get_all(in, &own_times_);
  get_all(in, &own_leaves_);
  if (has_values_ && !(own_times_.empty() && own_leaves_.empty())) in->fail("has own hits beside measured distances");
  const auto get_bits = [&](std::size_t count, std::size_t num_set, std::vector<std::uint64_t>* bits) {
    bits->resize((count + 63) / 64);
    in->get_raw(bits->data(), bits->size() * sizeof(std::uint64_t));
    for (const std::uint64_t word : *bits) num_set -= kernels::count_bits(word);
    const bool is_beyond = count % 64 != 0 && (bits->back() >> (count % 64)) != 0;
    if (is_beyond || num_set != 0) in->fail("has own hits that do not match its leaves");
  };
  get_bits(has_values_ ? 0 : leaves_.size(), own_times_.size(), &own_bits_);
  get_bits(own_times_.size(), own_leaves_.size(), &changed_bits_);
  get_all(in, &own_free_);
}

void CompressedField::check(const base::ByteReader& in) const {
  std::size_t num_occupied = 0;
  for (const std::uint64_t word : occupied_) {
    if (word == 0 && !has_values_) in.fail("has a cell of surfaces without any");
    num_occupied += kernels::count_bits(word);
  }
  if (num_occupied != leaves_.size()) in.fail("has leaves that do not match its states");
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (!is_block_in_range(blocks_[i].index)) in.fail("has a block index out of range");
    if (i > 0 && !(blocks_[i - 1].index < blocks_[i].index)) in.fail("has unsorted blocks");
    for (int cell = 0; cell < kCells; ++cell) {
      if ((occupied_of(blocks_[i], cell) & free_of(blocks_[i], cell)) != 0)
        in.fail("holds a voxel state that does not exist");
    }
  }
  check_own_free(in);
}

void CompressedField::check_own_free(const base::ByteReader& in) const {
  std::size_t next = 0;
  for (const Block& block : blocks_) {
    if ((block.own_cells & block.partly_own_cells) != 0) in.fail("has cells that are own both in part and as a whole");
    next += kernels::count_bits(block.partly_own_cells);
  }
  if (has_values_ && next != 0) in.fail("has own free space beside measured distances");
  if (next != own_free_.size()) in.fail("has own free space that does not match its cells");
  next = 0;
  for (const Block& block : blocks_) {
    for (std::uint64_t cells = block.own_cells | block.partly_own_cells; cells != 0; cells &= cells - 1) {
      const int cell = __builtin_ctzll(cells);
      const std::uint64_t free = free_of(block, cell);
      if (has(block.own_cells, cell)) {
        if (free == 0) in.fail("has own free space in a cell without any");
        continue;
      }
      const std::uint64_t own = own_free_[next++];
      if (own == 0 || own == free || (own & ~free) != 0) in.fail("has own free space that does not match its states");
    }
  }
}

}  // namespace voxnav::submap
