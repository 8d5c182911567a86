// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/occupancy/block_window.hpp"
#include "voxnav/occupancy/end_voxels.hpp"

namespace voxnav::occupancy {

/// When a ray that crosses a voxel with hits counts against it (see LocalMapConfig).
struct MissGuard {
  float distance_voxels = 0.25f;
  float end_voxels = 1.5f;
  int octants = 6;
};

/// Marks the voxels that the rays of one scan cross: one bit per voxel, set by however many rays. Several markers
/// may work on one map at once; each has its own marks.
class RayMarker {
 public:
  struct Row {
    std::uint64_t passed = 0;
    std::uint64_t surface = 0;  ///< voxels that hold hits of earlier scans and were not hit in this one
  };
  struct BlockMarks {
    std::array<Row, 64> rows{};
    std::uint32_t slot = 0;
  };
  /// A ray that crossed a voxel with hits: which octants it went through, all of them when it met the mean.
  struct Crossing {
    std::uint32_t slot;
    std::uint16_t offset;
    std::uint8_t octants;
  };

  explicit RayMarker(std::array<int, 3> num_blocks);

  /// Forgets all marks. Both references must outlive the casts; origin in voxel edges from the window's corner.
  void begin(const BlockWindow& window, const EndVoxels& ends, const MissGuard& guard, const geometry::Vec3& origin);
  enum class Ray {
    kHit,      ///< ends on a surface: its end voxel is not marked
    kClearing, ///< went on behind its end
    kNoReturn  ///< as clearing, but never speaks against a voxel that holds hits
  };
  /// Marks from the end voxel to the voxel of the origin exactly the voxels on the line.
  /// Source: Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987.
  void cast(const geometry::Vec3f& end, Ray kind);
  void merge(const RayMarker& other);

  const std::vector<BlockMarks>& blocks() const { return blocks_; }
  const std::vector<Crossing>& crossings() const { return crossings_; }
  /// Null when no ray crossed the block.
  const BlockMarks* marks(std::uint32_t slot) const { return index_[slot] < 0 ? nullptr : &blocks_[index_[slot]]; }
  std::size_t memory_bytes() const;

 private:
  struct Walk;
  BlockMarks& touch(std::uint32_t slot);
  void mark(BlockMarks& block, int offset, const Walk& walk);
  void cross_surface(std::uint32_t slot, int offset, const Walk& walk);

  std::array<int, 3> num_blocks_;
  const BlockWindow* window_ = nullptr;
  const EndVoxels* ends_ = nullptr;
  MissGuard guard_;
  geometry::Vec3f origin_ = geometry::Vec3f::Zero();
  std::vector<std::int32_t> index_;  ///< of a slot in blocks_, -1 = none
  std::vector<BlockMarks> blocks_;
  std::vector<Crossing> crossings_;
};

}  // namespace voxnav::occupancy
