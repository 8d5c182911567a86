// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxnav/submap/compressed_field.hpp"

namespace voxnav::submap {

/// An occupied voxel of a window, in voxels from the first voxel of the block in its middle.
struct WindowLeaf {
  int x, y, z;
  geometry::Vec3f mean;  ///< surface point from the centre of the voxel, voxel edges
  std::uint8_t hits;
  float phase;  ///< when it was seen, as a share of the submap's time
};

/// One block and up to 8 voxels around it as columns of bits: bit z + 8 of the column at (x, y). Unpacked from the
/// cells that lie there; made to be used again for the next block.
class FieldWindow {
 public:
  static constexpr int kHalo = 8;
  static constexpr int kSide = geometry::kBlockSide + 2 * kHalo;

  /// @param halo voxels around the block that are asked for, at most kHalo; more may be there (whole cells)
  void load(const CompressedField& field, const geometry::Index3& block, int halo);

  const std::vector<WindowLeaf>& leaves() const { return leaves_; }
  std::uint32_t free(int x, int y) const { return free_[at(x, y)]; }
  std::uint32_t occupied(int x, int y) const { return occupied_[at(x, y)]; }
  containers::State state(int x, int y, int z) const {
    if ((occupied(x, y) >> (z + kHalo)) & 1) return containers::State::kOccupied;
    return (free(x, y) >> (z + kHalo)) & 1 ? containers::State::kFree : containers::State::kUnknown;
  }
  /// The leaf of an occupied voxel.
  const WindowLeaf& leaf_at(int x, int y, int z) const {
    return leaves_[leaf_index_[at(x, y) * kSide + static_cast<std::size_t>(z + kHalo)]];
  }

 private:
  static std::size_t at(int x, int y) { return static_cast<std::size_t>(x + kHalo + kSide * (y + kHalo)); }
  void add_block(const CompressedField& field, int position, const geometry::Index3& first, int halo);

  std::array<std::uint32_t, kSide * kSide> free_;
  std::array<std::uint32_t, kSide * kSide> occupied_;
  std::vector<WindowLeaf> leaves_;
  std::vector<std::uint16_t> leaf_index_ = std::vector<std::uint16_t>(kSide * kSide * kSide);
};

/// What is known of the surface in a voxel.
struct LeafNormal {
  geometry::Vec3f normal{0.f, 0.f, 0.f};  ///< unit, towards free space, frame G; zero where nothing free is near
  float quality = 0.f;                    ///< confidence in the normal, 0 to 1
};

/// From the 26 voxels around a leaf, which must lie in the window.
LeafNormal estimate_normal(const FieldWindow& window, const WindowLeaf& leaf);

/// Leaves in planes seen from one side; their distances are taken from the plane.
constexpr float kPlanarQuality = 0.9f;
/// Leaves with free space on one side but no clear plane.
constexpr float kOneSidedQuality = 0.5f;
/// The same in front of another occupied voxel: the skin of a solid.
constexpr float kSolidQuality = 0.4f;
/// Leaves with free space all around: thin things.
constexpr float kThinQuality = 0.3f;

}  // namespace voxnav::submap
