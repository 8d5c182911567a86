// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

/// The inner loop of RayMarks: rays of one face, that is with the same longest axis a and the same sense along it.
namespace voxnav::occupancy::ray_walk {

constexpr int kWordShift = 5;

/// Bits of voxels in lines along a, in words of 32. The word of voxel (a, b, c) is zero + b * step_b + c * step_c + a
/// / 32.
struct Canvas {
  std::uint32_t* words;
  std::int32_t zero;
  std::int32_t step_b;
  std::int32_t step_c;
  int fraction_bits;  ///< of coordinates in fixed point
};

/// Rays from one origin, in voxel edges from the corner of the box, none of them negative. On axis a all ends lie on
/// one side of the origin.
struct Rays {
  const float *a, *b, *c;  ///< ends
  std::size_t size;
  float origin_a, origin_b, origin_c;
  bool is_ascending;  ///< along a, from the origin to the ends
};

/// Marks the voxels that the rays cross.
void mark_rays(const Rays& rays, const Canvas& canvas);

}  // namespace voxnav::occupancy::ray_walk
