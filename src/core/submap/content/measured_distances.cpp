// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/measured_distances.hpp"

#include <algorithm>
#include <utility>

namespace voxnav::submap {

std::optional<float> MeasuredDistances::at(std::size_t position, int offset) const {
  const Block& block = blocks_[position];
  const int cell = cell_of(offset);
  if (!has_bit(block.cells, cell)) return std::nullopt;
  const std::int8_t code =
      cells_[block.first + rank_of(block.cells, cell)][static_cast<std::size_t>(voxel_in_cell(offset))];
  if (code == kNone) return std::nullopt;
  return static_cast<float>(code * band_ / 127.0);
}

void MeasuredDistances::add_cell(int cell, const Cell& distances) {
  blocks_.back().cells |= bit_of(cell);
  cells_.push_back(distances);
}

std::int8_t MeasuredDistances::code_of(float distance) const {
  if (!(distance <= band_)) return kNone;
  const double code = std::max(-1.0, distance / band_) * 127.0;
  return static_cast<std::int8_t>(static_cast<int>(code + 128.5) - 128);  // rounds without a function call
}

void MeasuredDistances::finish() {
  blocks_.shrink_to_fit();
  cells_.shrink_to_fit();
}

std::vector<std::uint64_t> MeasuredDistances::cells_of_blocks() const {
  std::vector<std::uint64_t> out;
  for (const Block& block : blocks_) out.push_back(block.cells);
  return out;
}

bool MeasuredDistances::assign(const std::vector<std::uint64_t>& cells_of_blocks, std::vector<Cell> cells) {
  std::size_t count = 0;
  for (const std::uint64_t bits : cells_of_blocks) {
    blocks_.push_back({bits, static_cast<std::uint32_t>(count)});
    count += kernels::count_bits(bits);
  }
  cells_ = std::move(cells);
  return count == cells_.size();
}

}  // namespace voxnav::submap
