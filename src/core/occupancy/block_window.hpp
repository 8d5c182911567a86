// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "occupancy/octree_block.hpp"

namespace voxnav::occupancy {

/// A block that the window has left behind.
struct EvictedBlock {
  geometry::Index3 index;
  std::unique_ptr<OctreeBlock> block;
};

/// The rolling window of a local map: a bounded box of blocks around the sensor. A move of the window re-seats pointers
/// and hands out the blocks that are outside afterwards; blocks that stay are never copied.
class BlockWindow {
 public:
  BlockWindow(std::array<int, 3> num_blocks, double block_size_m);
  BlockWindow(const BlockWindow&) = delete;
  BlockWindow& operator=(const BlockWindow&) = delete;
  BlockWindow(BlockWindow&&) = default;
  BlockWindow& operator=(BlockWindow&&) = default;

  struct Move {
    bool moved = false;
    bool jumped = false;                ///< the new box shares nothing with the old one
    std::vector<EvictedBlock> evicted;  ///< sorted by index
  };
  /// Moves the box so that its middle block contains `center`, as soon as `center` lies more than a quarter of a block
  /// outside the present middle block.
  Move recenter(const geometry::Vec3& center);

  bool is_placed() const { return is_placed_; }
  const std::array<int, 3>& num_blocks() const { return num_blocks_; }
  int num_slots() const { return static_cast<int>(slots_.size()); }
  /// Lowest block of the box.
  const geometry::Index3& first_block() const { return first_; }
  geometry::Index3 first_voxel() const {
    return {first_.x * geometry::kBlockSide, first_.y * geometry::kBlockSide, first_.z * geometry::kBlockSide};
  }
  void place(const geometry::Index3& first_block);

  /// Returns the slot of a block, or -1 outside the box. Slots are ordered as Index3 is: by z, then y, then x.
  int slot_of(const geometry::Index3& block) const;
  geometry::Index3 block_at(int slot) const;
  OctreeBlock* at(int slot) { return slots_[slot].get(); }
  const OctreeBlock* at(int slot) const { return slots_[slot].get(); }
  const OctreeBlock* find(const geometry::Index3& block) const;
  OctreeBlock& ensure(int slot, std::uint8_t prior);
  std::vector<EvictedBlock> take_all();
  std::size_t memory_bytes() const;

 private:
  std::array<int, 3> num_blocks_;
  double block_size_m_;
  bool is_placed_ = false;
  geometry::Index3 first_;
  std::vector<std::unique_ptr<OctreeBlock>> slots_;
};

}  // namespace voxnav::occupancy
