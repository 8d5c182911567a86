// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/occupancy/block_window.hpp"
#include "voxnav/occupancy/end_voxels.hpp"
#include "voxnav/occupancy/scan_box.hpp"

namespace voxnav::occupancy {

/// When a ray that crosses a voxel with hits counts against it (see LocalMapConfig).
struct MissGuard {
  float sigmas = 2.0f;
  float spread_voxels = 0.05f;
  float end_voxels = 1.5f;
};

/// Marks the voxels that the rays of one scan cross: one bit per voxel, set by however many rays. Several markers
/// may work on one map at once; each has its own marks.
class RayMarker {
 public:
  /// 64 voxels of a block.
  struct Row {
    std::uint64_t passed = 0;
    std::uint64_t surface =
        0;  ///< voxels that hold hits of earlier scans and were neither hit nor seen through in this
  };
  /// A ray that crossed a voxel with hits: which octants it went through, all of them when it met the mean.
  struct Crossing {
    SurfaceLeaf* leaf;
    std::uint32_t slot;
    std::uint16_t offset;
    std::uint8_t octants;
  };

  /// Forgets all marks. All references must outlive the casts; origin in voxel edges from the window's corner.
  void begin(BlockWindow& window, const EndVoxels& ends, const ScanBox& box, const MissGuard& guard,
             const geometry::Vec3& origin);
  /// Marks every voxel on the line from `end` to the origin, both included. A ray that is no evidence against
  /// surfaces leaves voxels that hold hits alone. Both points must lie in the box.
  /// Source: Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987; here slab by
  /// slab along the longest axis, so that the steps do not wait for each other.
  void cast(const geometry::Vec3f& end, bool is_evidence);
  void merge(const RayMarker& other);

  /// Blocks of the box that were crossed, in the order of their number.
  std::vector<std::uint32_t> touched_blocks() const;
  const Row* rows(std::uint32_t block) const { return rows_.data() + 64 * static_cast<std::size_t>(block); }
  const std::vector<Crossing>& crossings() const { return crossings_; }
  std::size_t memory_bytes() const;

 private:
  struct Line;
  struct Ray;
  struct Across {
    std::int64_t b;
    std::int64_t c;
  };
  void flush(std::uint32_t row_index, std::uint64_t bits, const Ray& ray);
  void walk(const Line& line, const Ray& ray);
  static std::uint32_t corner(const Line& line, const Across& from, const Across& to);
  void cross_surfaces(std::uint32_t row, std::uint64_t bits, const Ray& ray);
  bool cross_surface(std::uint32_t block, int offset, const Ray& ray);

  BlockWindow* window_ = nullptr;
  const ScanBox* box_ = nullptr;
  MissGuard guard_;
  geometry::Vec3f origin_ = geometry::Vec3f::Zero();
  std::vector<Row> rows_;              ///< 64 per block of the box; clean outside begin() .. next begin()
  std::vector<std::uint8_t> touched_;  ///< per block of the box
  std::vector<Crossing> crossings_;
};

}  // namespace voxnav::occupancy
