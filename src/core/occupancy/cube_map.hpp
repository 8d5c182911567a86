// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/lanes.hpp"

/// Six square images around the sensor, one for each face of a cube.
namespace voxnav::occupancy::cube_map {

/// Where directions fall, eight at once.
struct Projection {
  base::lanes::Ints face;     ///< x -x y -y z -z
  base::lanes::Floats u, v;   ///< pixels from the corner of the face
  base::lanes::Floats scale;  ///< pixels per unit of length, across
};

/// @param half_side  of a face, pixels
VOXNAV_INLINE Projection project(base::lanes::Floats x, base::lanes::Floats y, base::lanes::Floats z, float half_side) {
  using namespace base::lanes;  // NOLINT: the vector types of this function
  const Ints is_y = absolute(y) > absolute(x);
  const Floats xy = is_y ? y : x;
  const Ints is_z = absolute(z) > absolute(xy);
  const Floats a = is_z ? z : xy;
  const Floats b = is_z ? x : is_y ? z : y, c = is_z ? y : is_y ? x : z;
  const Floats scale = half_side / absolute(a);
  return {(is_z & 4) + (~is_z & is_y & 2) + ((a < 0.0f) & 1), b * scale + half_side, c * scale + half_side, scale};
}

/// The pixel of a coordinate, 0 to side - 1; that of NaN is the first.
VOXNAV_INLINE base::lanes::Ints pixel(base::lanes::Floats coordinate, int side) {
  using namespace base::lanes;  // NOLINT: the vector types of this function
  return truncated(smaller(larger(coordinate, Floats{}), Floats{} + static_cast<float>(side - 1)));
}

}  // namespace voxnav::occupancy::cube_map
