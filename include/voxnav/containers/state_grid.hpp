// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::containers {

/// What is known of a voxel. The values are part of the Python face and of messages.
enum class State : std::uint8_t { kUnknown = 0, kFree = 1, kOccupied = 2 };

/// The states of one block of 16^3 voxels, two bits each, voxel order of geometry::offset_in_block().
struct StateBlock {
  std::array<std::uint64_t, geometry::kBlockVolume / 32> words{};

  State get(int offset) const { return static_cast<State>((words[offset >> 5] >> (2 * (offset & 31))) & 3u); }
  void set(int offset, State state) {
    const int shift = 2 * (offset & 31);
    std::uint64_t& word = words[offset >> 5];
    word = (word & ~(std::uint64_t{3} << shift)) | (static_cast<std::uint64_t>(state) << shift);
  }
  bool all_unknown() const;
};

/// A grid of voxels in three states, in blocks: the form in which occupancy leaves a map for messages, submaps and the
/// planner. Blocks that are not there are unknown. A block takes 1 KiB beside its index. Not thread-safe.
class StateGrid {
 public:
  using Blocks = std::unordered_map<geometry::Index3, StateBlock, geometry::Index3Hash>;

  /// @throws std::invalid_argument unless resolution_m > 0
  explicit StateGrid(double resolution_m);

  double resolution_m() const { return resolution_m_; }
  State state(const geometry::Index3& voxel) const;
  /// The state of the voxel that holds a point; unknown for points that are not finite.
  State state(const geometry::Vec3& point) const;
  void set(const geometry::Index3& voxel, State state);

  const StateBlock* find_block(const geometry::Index3& block) const;
  StateBlock& block(const geometry::Index3& block) { return blocks_[block]; }
  /// A block that holds nothing but unknown is removed.
  void replace_block(const geometry::Index3& block, const StateBlock& states);
  void erase_block(const geometry::Index3& block) { blocks_.erase(block); }
  void clear() { blocks_.clear(); }

  const Blocks& blocks() const { return blocks_; }
  std::vector<geometry::Index3> sorted_block_indices() const;
  std::size_t memory_bytes() const;

 private:
  double resolution_m_;
  Blocks blocks_;
};

}  // namespace voxnav::containers
