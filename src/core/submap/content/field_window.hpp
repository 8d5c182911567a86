// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/voxel_window.hpp"
#include "submap/content/compressed_field.hpp"

namespace voxnav::submap {

/// An occupied voxel of a window, in voxels from the first voxel of the block in its middle.
struct WindowLeaf {
  std::int16_t x, y, z;
  CompressedField::Leaf leaf;
  float phase;  ///< when it was seen, as a share of the submap's time

  /// Surface point from the centre of the voxel, voxel edges.
  geometry::Vec3f mean() const { return geometry::Vec3f(leaf.mean[0], leaf.mean[1], leaf.mean[2]) * (1.0f / 254.0f); }
};

/// One block and up to 8 voxels around it as rows of bits along x: bit x + 8 of the row at (y, z). Unpacked from the
/// cells that lie there; made to be used again for the next block.
class FieldWindow {
 public:
  static constexpr int kHalo = 8;
  static constexpr int kSide = geometry::kBlockSide + 2 * kHalo;
  /// x y z 1 and y z x 0 of a surface point: what its products take, without exchanging lanes.
  using Point = kernels::WindowPoint;

  /// @param halo voxels around the block that are asked for, at most kHalo; more may be there (whole cells)
  void load(const CompressedField& field, const geometry::Index3& block, int halo);

  /// By z, y and x.
  const std::vector<WindowLeaf>& leaves() const { return leaves_; }
  /// Surface point of each of them, from the centre of the first voxel of the block.
  const Point* points() const { return points_.data(); }
  std::uint32_t free(int y, int z) const { return free_[at(y, z)]; }
  std::uint32_t occupied(int y, int z) const { return occupied_[at(y, z)]; }
  /// Number of the first leaf of a row; the others follow it.
  unsigned first_leaf(int y, int z) const { return first_leaf_[at(y, z)]; }
  containers::State state(int x, int y, int z) const {
    if ((occupied(y, z) >> (x + kHalo)) & 1) return containers::State::kOccupied;
    return (free(y, z) >> (x + kHalo)) & 1 ? containers::State::kFree : containers::State::kUnknown;
  }

  /// The same for kernels; ends with the next load().
  kernels::VoxelWindow view() const {
    static_assert(kHalo == kernels::kWindowHalo && kSide == kernels::kWindowSide, "one window");
    return {free_.data(), occupied_.data(), first_leaf_.data(), points_.data(), points_.size()};
  }

 private:
  /// A cell with leaves.
  struct OccupiedCell {
    int x, y, z;
    std::uint64_t voxels;
    const CompressedField::Leaf* leaves;
  };

  static std::size_t at(int y, int z) { return static_cast<std::size_t>(y + kHalo + kSide * (z + kHalo)); }
  void add_block(const CompressedField& field, int position, const geometry::Index3& first, int halo);
  void number_leaves();
  void take_leaves(const CompressedField& field, const OccupiedCell& cell);

  using Rows = std::array<std::uint32_t, kSide * kSide>;
  Rows free_;
  Rows occupied_;
  std::array<std::uint16_t, kSide * kSide> first_leaf_;
  std::array<std::uint16_t, kSide * kSide> next_leaf_;  ///< of each row, while they are taken
  std::vector<OccupiedCell> cells_;
  std::vector<WindowLeaf> leaves_;
  std::vector<Point> points_;
};

/// Numbers of the leaves that lie in the block itself.
std::vector<std::uint16_t> leaves_of_block(const FieldWindow& window);

/// What is known of the surface in a voxel.
struct LeafNormal {
  geometry::Vec3f normal{0.f, 0.f, 0.f};  ///< unit, towards free space, frame G; zero where nothing free is near
  float quality = 0.f;                    ///< confidence in the normal, 0 to 1
};

/// From the 26 voxels around each of these leaves, by number; those voxels must lie in the window.
void estimate_normals(const FieldWindow& window, const std::vector<std::uint16_t>& leaves,
                      std::vector<LeafNormal>* normals);

/// Leaves in planes seen from one side; their distances are taken from the plane.
constexpr float kPlanarQuality = 0.9f;
/// Leaves with free space on one side but no clear plane.
constexpr float kOneSidedQuality = 0.5f;
/// The same in front of another occupied voxel: the skin of a solid.
constexpr float kSolidQuality = 0.4f;
/// Leaves with free space all around: thin things.
constexpr float kThinQuality = 0.3f;

}  // namespace voxnav::submap
