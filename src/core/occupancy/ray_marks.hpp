// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "occupancy/scan_box.hpp"
#include "occupancy/surface_leaves.hpp"

namespace voxnav::occupancy {

/// Marks the voxels that the rays of one scan cross. Rays are told apart by the face of a cube around the sensor that
/// they leave through. Each face has a bit image of what its rays can reach, made of lines of voxels along its axis: a
/// ray stays in a line for several voxels, which are marked with one word, and one face of a box of 10^8 voxels fits
/// the cache of one core. Faces do not share anything, so threads can work on different ones.
class RayMarks {
 public:
  static constexpr int kFaces = 6;

  /// Takes the ends of the rays, which lie in the box and are given in voxel edges from the window's corner. `box` must
  /// stay while marks are used. O(rays).
  void begin(const ScanBox& box, const std::vector<geometry::Vec3f>& ends, const geometry::Vec3& origin);
  /// Marks every voxel on the lines from the origin through the face with the nth most rays, both ends included. It is
  /// to be called once for each face, by one thread each. A line is off by less than n^2 2^-30 voxels in a box of n
  /// voxels a side. O(voxels crossed + voxels within reach / 256). Source: Amanatides and Woo, A Fast Voxel Traversal
  /// Algorithm for Ray Tracing, Eurographics 1987; here over the two shorter axes only, as runs of voxels along the
  /// longest.
  void cast(int nth);

  bool is_crossed(std::uint32_t block) const;
  /// Sets the bits of the crossed voxels of a block.
  void add_to(std::uint32_t block, VoxelBits* bits) const;
  std::size_t memory_bytes() const;

 private:
  /// The blocks of the box that the rays of a face can reach, from `low` to before `high` on an axis.
  struct Reach {
    std::int32_t low, high;
  };
  /// Lines of voxels along the axis a of the face, ordered by b and then c, the other two axes in the order of x, y, z:
  /// what a block needs then lies together. There is one line to spare on each side, since rounding may lead a ray
  /// there. Lines are made of words of 32 voxels; the word of voxel (a, b, c) is zero + b * step_b + c * step_c + a
  /// / 32.
  struct Face {
    std::size_t rays_begin = 0, rays_end = 0;
    std::array<Reach, 3> reach{};  ///< on a, b, c
    std::int32_t step_b = 0, step_c = 0;
    std::int32_t zero = 0;  ///< may lie outside the image, which begins where the reach does
    std::vector<std::uint32_t> words;
    std::vector<std::uint8_t> crossed;  ///< per block of the box; empty: none
  };
  void sort(const std::vector<geometry::Vec3f>& ends);
  void find_reach(int face);
  void clear(int face);
  void find_crossed(int face);
  const std::uint8_t* line_of(int face, int a, int b, int c) const;

  const ScanBox* box_ = nullptr;
  geometry::Vec3f origin_;  ///< from the corner of the box, as the rays
  int fraction_bits_ = 0;
  std::array<Face, kFaces> faces_;  ///< -x x -y y -z z
  std::array<int, kFaces> by_size_{};
  std::vector<std::uint8_t> face_of_;
  std::array<std::vector<float>, 3> along_;  ///< ends of rays on the axes a, b, c of their face, face by face
};

}  // namespace voxnav::occupancy
