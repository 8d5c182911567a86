// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "occupancy/end_voxels.hpp"
#include "occupancy/log_odds.hpp"

namespace voxnav::occupancy {

/// A voxel that the map believed to be free when a scan first hit it, not long ago.
struct NewVoxel {
  std::uint16_t offset = 0;       ///< geometry::offset_in_block()
  std::uint8_t level_before = 0;  ///< log-odds level before the first hit
  bool is_clear = false;          ///< it was surely free, and no surface is beside it; see NewHit
  bool is_moving = false;         ///< its hits are those of something that moves
  bool is_seen_through = false;   ///< a scan saw through its surface since the last hit
  std::uint32_t first_scan = 0;   ///< OctreeForest::scans at the first hit
  std::uint32_t last_scan = 0;    ///< the same at the last hit
};

/// The new voxels of one block, sorted by offset. Something that moves into free space shows in new voxels only, so
/// these are what has to be remembered to undo its hits when it has moved on.
class NewVoxels {
 public:
  /// The number of new voxels that a block remembers at most, which bounds its memory.
  static constexpr std::size_t kMax = 256;
  /// A voxel that is still hit this many scans after its first hit is not new any more, unless it is known to move.
  static constexpr std::uint32_t kNewScans = 40;

  /// Records the hits of a scan: those of voxels that are free become new voxels.
  /// @param log_odds  levels of the block before the hits are counted
  /// Returns how many hit voxels are one too many, and are left out. O(hits + new voxels).
  std::size_t add_hits(const HitVoxel* begin, const HitVoxel* end, const std::uint8_t* log_odds,
                       const StateLevels& levels, std::uint32_t scan);
  /// Records which voxels the scan saw through, and forgets those that are not new any more. O(new voxels).
  void end_scan(const VoxelBits& seen_through, std::uint32_t scan);
  NewVoxel* find(int offset);
  const NewVoxel* find(int offset) const;
  void erase(int offset);
  /// Adds a voxel that is not among them. Returns false for one too many, which is left out.
  bool add(const NewVoxel& voxel);
  void clear() { voxels_.clear(); }

  bool empty() const { return voxels_.empty(); }
  const std::vector<NewVoxel>& all() const { return voxels_; }
  std::size_t heap_bytes() const { return voxels_.capacity() * sizeof(NewVoxel); }

 private:
  std::vector<NewVoxel> voxels_;
};

}  // namespace voxnav::occupancy
