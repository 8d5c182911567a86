// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

/// The inner loop of occupancy::RayMarks: rays of one face, which have the same longest axis a and the same sense along
/// it. A ray is walked from one change of voxel on the shorter axes b and c to the next, in fixed point, and marks the
/// run of voxels along a between them. Source: Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing,
/// Eurographics 1987; differs: runs of voxels instead of single ones.
namespace voxnav::kernels::ray_walk {

constexpr int kWordShift = 5;

/// A bit image whose voxels lie in lines along the axis a, in words of 32 bits: voxel (a, b, c) is bit a % 32 of word
/// zero + b * step_b + c * step_c + a / 32.
struct Canvas {
  std::uint32_t* words;
  std::int32_t zero;
  std::int32_t step_b;
  std::int32_t step_c;
  int fraction_bits;  ///< fractional bits of fixed-point coordinates
};

/// Rays from one origin, in voxel edges from the corner of the box, none of them negative. On axis a all ends lie on
/// one side of the origin.
struct Rays {
  const float *a, *b, *c;  ///< coordinates of the ends
  std::size_t size;
  float origin_a, origin_b, origin_c;
  bool is_ascending;  ///< whether a rises from the origin to the ends
};

/// Marks the voxels that the rays cross.
void mark_rays(const Rays& rays, const Canvas& canvas);

namespace reference {
/// Marks the same voxels ray by ray: the scalar reference.
void mark_rays(const Rays& rays, const Canvas& canvas);
}  // namespace reference

}  // namespace voxnav::kernels::ray_walk
