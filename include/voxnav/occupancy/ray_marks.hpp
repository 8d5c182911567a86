// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxnav/occupancy/scan_box.hpp"
#include "voxnav/occupancy/surface_leaves.hpp"

namespace voxnav::occupancy {

/// Ends of rays, coordinate by coordinate, so that several rays are walked at once. Window coordinates.
struct RayEnds {
  std::array<std::vector<float>, 3> along;

  std::size_t size() const { return along[0].size(); }
  void clear() {
    for (auto& axis : along) axis.clear();
  }
  void reserve(std::size_t n) {
    for (auto& axis : along) axis.reserve(n);
  }
  void push_back(const geometry::Vec3f& end) {
    for (int axis = 0; axis < 3; ++axis) along[static_cast<std::size_t>(axis)].push_back(end[axis]);
  }
  std::size_t memory_bytes() const { return 3 * along[0].capacity() * sizeof(float); }
};

/// Marks the voxels that the rays of one scan cross. There are three bit images of the box, one for rays along each
/// axis, made of lines of voxels along that axis: a ray stays in a line for several voxels, which are marked with one
/// word, and a box of 10^8 voxels fits the cache. One per thread.
class RayMarks {
 public:
  /// Nothing is marked afterwards. `box` must outlive the casts. O(voxels of the box / 32).
  void begin(const ScanBox& box);
  /// Marks every voxel on the lines from rays `first` to `last` (not included) of `ends` to the origin, both ends
  /// included, all in the box and in voxel edges from the window's corner. Off by less than n^2 2^-30 voxels in a box
  /// of n voxels a side.
  /// Source: Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987; here over the
  /// two shorter axes only, as runs of voxels along the longest.
  void cast(const RayEnds& ends, std::size_t first, std::size_t last, const geometry::Vec3& origin);

  /// Call after the last cast: finds the blocks that were crossed. O(voxels of the box / 256).
  void finish();

  bool is_crossed(std::uint32_t block) const { return crossed_[block] != 0; }
  /// Sets the bits of the crossed voxels of a block.
  void add_to(std::uint32_t block, VoxelBits* bits) const;
  std::size_t memory_bytes() const { return words_.capacity() * sizeof(words_[0]) + crossed_.capacity(); }

  /// Line b + c * lines_b of an image holds the voxels along its axis a, where b and c are the other two axes, in the
  /// order of x, y, z: what a block needs then lies together. There is one line to spare on each side, since rounding
  /// may lead a ray there. All in words of 32 voxels.
  struct Image {
    std::int32_t step_b = 0;
    std::int32_t step_c = 0;
    std::int32_t zero = 0;  ///< first word of line (0, 0)
  };

 private:
  const std::uint8_t* line_of(int axis, int a, int b, int c) const;

  const ScanBox* box_ = nullptr;
  std::array<Image, 3> images_;
  int fraction_bits_ = 0;
  std::vector<std::uint32_t> words_;
  std::vector<std::uint8_t> crossed_;  ///< per block of the box, a bit per image
};

}  // namespace voxnav::occupancy
