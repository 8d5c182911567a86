// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "occupancy/scan_box.hpp"
#include "occupancy/surface_leaves.hpp"

namespace voxnav::occupancy {

/// Ray casting: marks the voxels that the rays of one scan cross. Rays are sorted by the face of a cube around the
/// sensor through which they leave. Each face has a bit image of the voxels that its rays can reach, made of lines of
/// voxels along its axis: a ray stays in a line for several voxels, which are marked with one word, and one face of a
/// box of 10^8 voxels fits the cache of one core. Faces share no memory, so threads can work on different faces.
class RayMarks {
 public:
  static constexpr int kFaces = 6;

  /// Takes the ends of the rays, which lie in the box and are given in voxel edges from the window's corner. The caller
  /// keeps `box` in place while the marks are used. O(rays).
  void begin(const ScanBox& box, const std::vector<geometry::Vec3f>& ends, const geometry::Vec3& origin);
  /// Marks every voxel on the rays through the face with the nth most rays, both ends included. It is called once for
  /// each face, each time by one thread; faces with many rays come first, so that threads finish together. A ray is off
  /// by less than n^2 2^-30 voxels in a box of n voxels a side. O(voxels crossed + voxels within reach / 256).
  /// Source: Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987; here over the two
  /// shorter axes only, as runs of voxels along the longest.
  void cast(int nth);

  bool is_crossed(std::uint32_t block) const;
  /// Sets the bits of the crossed voxels of a block.
  void add_to(std::uint32_t block, VoxelBits* bits) const;
  std::size_t memory_bytes() const;

 private:
  /// The half-open range [low, high) of blocks of the box that the rays of a face can reach on an axis.
  struct Reach {
    std::int32_t low, high;
  };
  /// The bit image of a face: lines of voxels along the axis a of the face, ordered by b and then c, the other two axes
  /// in the order of x, y, z, so that the lines of one block lie close together. There is one spare line on each side,
  /// since rounding may lead a ray there. Lines are made of words of 32 voxels; the word of voxel (a, b, c) is
  /// zero + b * step_b + c * step_c + a / 32.
  struct Face {
    std::size_t rays_begin = 0, rays_end = 0;
    std::array<Reach, 3> reach{};  ///< on the axes a, b, c
    std::int32_t step_b = 0, step_c = 0;
    std::int32_t zero = 0;  ///< word of voxel (0, 0, 0); it may lie before the image, which begins at the reach
    std::vector<std::uint32_t> words;
    std::vector<std::uint8_t> crossed;  ///< for each block of the box whether a ray crosses it; empty = none is crossed
  };
  void sort(const std::vector<geometry::Vec3f>& ends);
  void find_reach(int which);
  void clear(int which);
  void find_crossed(int which);
  const std::uint8_t* line_of(int which, int a, int b, int c) const;

  const ScanBox* box_ = nullptr;
  geometry::Vec3f origin_;  ///< origin of the rays, in voxel edges from the corner of the box
  int fraction_bits_ = 0;
  std::array<Face, kFaces> faces_;  ///< in the order -x x -y y -z z
  std::array<int, kFaces> by_size_{};
  std::vector<std::uint8_t> face_of_;
  std::array<std::vector<float>, 3> along_;  ///< ends of rays on the axes a, b, c of their face, face by face
};

}  // namespace voxnav::occupancy
