// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "occupancy/log_odds.hpp"
#include "occupancy/new_voxels.hpp"
#include "occupancy/surface_leaves.hpp"
#include "voxnav/occupancy/map_content.hpp"

namespace voxnav::occupancy {

/// The states that occur below a node of the octree, one bit each. A voxel has exactly one of the bits.
enum Contains : std::uint8_t { kContainsUnknown = 1, kContainsFree = 2, kContainsOccupied = 4 };

/// One root of the forest: an octree over 16^3 voxels with all levels stored flat, x fastest. Level 0 are the
/// voxels, level 4 the root; node (x, y, z) of level k has the children (2x + i, 2y + j, 2z + k) of level k - 1.
class OctreeBlock {
 public:
  static constexpr int kLevels = 4;
  using Flags = std::array<std::uint8_t, geometry::kBlockVolume>;

  explicit OctreeBlock(std::uint8_t prior) { log_odds.fill(prior); }

  alignas(16) std::array<std::uint8_t, geometry::kBlockVolume> log_odds;
  SurfaceLeaves leaves;
  NewVoxels new_voxels;
  VoxelBits seen{};              ///< voxels that were crossed by a ray, hit or set since the last handover
  std::uint64_t changed_at = 0;  ///< LocalMap::sequence() when a state last changed

  /// Prefetches the memory that an update of the block reads.
  void prefetch() const {
    const char* at = reinterpret_cast<const char*>(this);
    for (std::size_t i = 0; i < sizeof(*this); i += 64) __builtin_prefetch(at + i);
  }

  /// Computes the Contains bit of every voxel.
  void leaf_flags(const StateLevels& levels, Flags* flags) const;
  /// Recomputes all inner nodes from the voxels and their flags.
  void refresh(const Flags& flags);

  /// Inner nodes, level 1 to 4: the highest log-odds level of the voxels below, and their Contains bits.
  std::uint8_t node_max(int level, int x, int y, int z) const { return max_[node_index(level, x, y, z)]; }
  std::uint8_t node_flags(int level, int x, int y, int z) const { return flags_[node_index(level, x, y, z)]; }
  std::uint8_t root_flags() const { return flags_[kNodes - 1]; }
  /// False until the first refresh(): afterwards the root has at least one Contains bit.
  bool is_summarised() const { return root_flags() != 0; }
  bool has_known() const { return (root_flags() & (kContainsFree | kContainsOccupied)) != 0; }

  containers::StateBlock states(const StateLevels& levels) const;
  /// @param num_scans  number of scans since the last handover
  ContentBlock content(const geometry::Index3& index, const StateLevels& levels, int num_scans) const;
  bool is_seen(int offset) const { return ((seen[offset >> 6] >> (offset & 63)) & 1u) != 0; }
  void mark_seen(int offset) { seen[offset >> 6] |= std::uint64_t{1} << (offset & 63); }
  /// Begins to collect observations for the next submap: everything seen before counts as remembered from here on.
  void begin_handover();
  std::size_t memory_bytes() const { return sizeof(*this) + leaves.heap_bytes() + new_voxels.heap_bytes(); }

 private:
  VoxelBits observed_free(const StateLevels& levels) const;
  void leave_out_moving(const StateLevels& levels, ContentBlock* content) const;
  std::uint64_t free_bits(std::size_t word, const StateLevels& levels) const;
  std::uint64_t occupied_bits(std::size_t word, const StateLevels& levels) const;
  static constexpr int kNodes = 512 + 64 + 8 + 1;
  static constexpr std::array<int, kLevels + 1> kFirst{0, 0, 512, 576, 584};
  static int node_index(int level, int x, int y, int z) {
    const int shift = geometry::kBlockShift - level;
    return kFirst[level] + x + (y << shift) + (z << (2 * shift));
  }

  std::array<std::uint8_t, kNodes> max_{};
  std::array<std::uint8_t, kNodes> flags_{};
};

}  // namespace voxnav::occupancy
