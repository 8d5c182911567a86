// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/voxel_window.hpp"
#include "submap/content/submap_content.hpp"

namespace voxnav::submap {

/// One block of a submap with a halo of up to 8 voxels, as rows of bits along x: voxel x is bit x + 8 of the row at
/// (y, z). Coordinates are voxels from the first voxel of the block. The window is unpacked once for each block, so
/// that what is computed for every voxel of it (distances, normals) finds the neighbours without a search. Its memory
/// is kept for the next block.
class ContentWindow {
 public:
  static constexpr int kHalo = 8;
  static constexpr int kSide = geometry::kBlockSide + 2 * kHalo;
  static constexpr std::size_t kRows = std::size_t{kSide} * kSide;

  /// Unpacks a block and its surroundings.
  /// @param halo  voxels that are needed around the block, at most kHalo; as whole cells are unpacked, there may be
  /// more
  void load(const SubmapContent& content, const geometry::Index3& block, int halo);

  /// The occupied voxels, sorted by z, y and x. The index of a voxel in this list is its number in the window.
  const std::vector<geometry::Index3>& voxels() const { return voxels_; }
  /// For each of them the number of its surface point in the submap.
  const std::vector<std::uint32_t>& numbers() const { return numbers_; }
  /// Offset of the surface point of the i-th of them from the centre of its voxel, voxel edges.
  geometry::Vec3f mean(std::size_t i) const {
    const auto& mean = content_points_->believed(numbers_[i]).mean;
    return geometry::Vec3f(mean[0], mean[1], mean[2]) * (1.0f / 254.0f);
  }

  std::uint32_t free(int y, int z) const { return free_[at(y, z)]; }
  std::uint32_t occupied(int y, int z) const { return occupied_[at(y, z)]; }
  containers::VoxelState state(int x, int y, int z) const {
    if ((occupied(y, z) >> (x + kHalo)) & 1) return containers::VoxelState::kOccupied;
    return (free(y, z) >> (x + kHalo)) & 1 ? containers::VoxelState::kFree : containers::VoxelState::kUnknown;
  }

  /// The window in the form that kernels read, with surface points relative to the centre of the first voxel of the
  /// block. It is valid until the next load().
  kernels::VoxelWindow view() const {
    static_assert(kHalo == kernels::kWindowHalo && kSide == kernels::kWindowSide, "one window");
    return {free_.data(), occupied_.data(), first_of_row_.data(), points_.data(), points_.size()};
  }

 private:
  static std::size_t at(int y, int z) { return kernels::VoxelWindow::row(y, z); }
  /// A cell with occupied voxels: the coordinates of its first voxel, and the number of its first surface point.
  struct OccupiedCell {
    int x, y, z;
    std::uint64_t voxels;
    std::size_t first_number;
  };

  void add_block(const BlockStates& states, std::size_t position, const geometry::Index3& first, int halo);
  void count_rows();
  void take_points(const OccupiedCell& cell);

  using Rows = std::array<std::uint32_t, kRows>;
  const VoxelPoints* content_points_ = nullptr;
  Rows free_;
  Rows occupied_;
  std::array<std::uint16_t, kRows> first_of_row_;
  std::array<std::uint16_t, kRows> next_of_row_;  ///< next free entry of each row, while points are taken
  std::vector<OccupiedCell> cells_;
  std::vector<geometry::Index3> voxels_;
  std::vector<std::uint32_t> numbers_;
  std::vector<kernels::WindowPoint> points_;
};

/// Returns the numbers of the occupied voxels of a window that lie in the block itself, without the halo.
std::vector<std::uint16_t> voxels_of_block(const ContentWindow& window);

}  // namespace voxnav::submap
