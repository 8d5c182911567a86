// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/block_window.hpp"

#include <cstdlib>

namespace voxnav::occupancy {
namespace {

constexpr double kHysteresisBlocks = 0.25;

/// Returns the index of the block that shall be the middle one along an axis. It stays the same while the centre is in
/// that block or near it, so that a sensor that hovers at the edge of a block does not move the window back and forth.
int middle_of(double center_blocks, int middle) {
  const bool stays = center_blocks >= middle - kHysteresisBlocks && center_blocks <= middle + 1 + kHysteresisBlocks;
  return stays ? middle : static_cast<int>(std::floor(center_blocks));
}

}  // namespace

BlockWindow::BlockWindow(std::array<int, 3> num_blocks, double block_size_m)
    : num_blocks_(num_blocks), block_size_m_(block_size_m) {
  slots_.resize(static_cast<std::size_t>(num_blocks[0]) * num_blocks[1] * num_blocks[2]);
}

int BlockWindow::slot_of(const geometry::Index3& block) const {
  const geometry::Index3 local = block - first_;
  const bool inside = local.x >= 0 && local.y >= 0 && local.z >= 0 && local.x < num_blocks_[0] &&
                      local.y < num_blocks_[1] && local.z < num_blocks_[2];
  return inside && is_placed_ ? local.x + num_blocks_[0] * (local.y + num_blocks_[1] * local.z) : -1;
}

geometry::Index3 BlockWindow::block_at(int slot) const {
  const int x = slot % num_blocks_[0];
  const int yz = slot / num_blocks_[0];
  return first_ + geometry::Index3{x, yz % num_blocks_[1], yz / num_blocks_[1]};
}

const OctreeBlock* BlockWindow::find(const geometry::Index3& block) const {
  const int slot = slot_of(block);
  return slot < 0 ? nullptr : slots_[slot].get();
}

OctreeBlock& BlockWindow::ensure(int slot, std::uint8_t prior) {
  if (!slots_[slot]) slots_[slot] = std::make_unique<OctreeBlock>(prior);
  return *slots_[slot];
}

void BlockWindow::place(const geometry::Index3& first_block) {
  first_ = first_block;
  is_placed_ = true;
}

BlockWindow::Move BlockWindow::recenter(const geometry::Vec3& center) {
  const geometry::Index3 half{num_blocks_[0] / 2, num_blocks_[1] / 2, num_blocks_[2] / 2};
  Move move;
  if (!is_placed_) {
    place(geometry::index_of(center, block_size_m_) - half);
    move.moved = true;
    return move;
  }
  const geometry::Index3 old_middle = first_ + half;
  const geometry::Index3 middle{middle_of(center.x() / block_size_m_, old_middle.x),
                                middle_of(center.y() / block_size_m_, old_middle.y),
                                middle_of(center.z() / block_size_m_, old_middle.z)};
  if (middle == old_middle) return move;
  const geometry::Index3 shift = middle - old_middle;
  move.moved = true;
  move.jumped =
      std::abs(shift.x) >= num_blocks_[0] || std::abs(shift.y) >= num_blocks_[1] || std::abs(shift.z) >= num_blocks_[2];
  std::vector<std::unique_ptr<OctreeBlock>> old(slots_.size());
  old.swap(slots_);
  std::vector<geometry::Index3> indices(old.size());
  for (std::size_t slot = 0; slot < old.size(); ++slot) indices[slot] = block_at(static_cast<int>(slot));
  place(first_ + shift);
  for (std::size_t slot = 0; slot < old.size(); ++slot) {
    if (!old[slot]) continue;
    const int seat = slot_of(indices[slot]);
    if (seat >= 0) {
      slots_[seat] = std::move(old[slot]);
    } else {
      move.evicted.push_back({indices[slot], std::move(old[slot])});
    }
  }
  return move;
}

std::vector<EvictedBlock> BlockWindow::take_all() {
  std::vector<EvictedBlock> out;
  for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
    if (slots_[slot]) out.push_back({block_at(static_cast<int>(slot)), std::move(slots_[slot])});
  }
  return out;
}

std::size_t BlockWindow::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + slots_.capacity() * sizeof(slots_[0]);
  for (const auto& block : slots_) bytes += block ? block->memory_bytes() : 0;
  return bytes;
}

}  // namespace voxnav::occupancy
