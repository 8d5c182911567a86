// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "kernels/lanes.hpp"

/// Six square images around the sensor, one for each face of a cube: x, -x, y, -y, z, -z.
namespace voxnav::kernels::cube_map {

/// The positions of eight directions in a cube map.
struct Projection {
  lanes::Ints face;
  lanes::Floats u, v;   ///< position from the corner of the face, pixels
  lanes::Floats scale;  ///< pixels for a unit of length at right angles to the direction
};

/// @param half_side  half the side of a face, pixels
VOXNAV_INLINE Projection project(lanes::Floats x, lanes::Floats y, lanes::Floats z, float half_side) {
  using namespace lanes;  // NOLINT: the vector types of this function
  const Ints is_y = absolute(y) > absolute(x);
  const Floats xy = is_y ? y : x;
  const Ints is_z = absolute(z) > absolute(xy);
  const Floats a = is_z ? z : xy;
  const Floats b = is_z ? x : is_y ? z : y, c = is_z ? y : is_y ? x : z;
  const Floats scale = half_side / absolute(a);
  return {(is_z & 4) + (~is_z & is_y & 2) + ((a < 0.0f) & 1), b * scale + half_side, c * scale + half_side, scale};
}

/// Returns the pixel of a coordinate, 0 to side - 1; the first one for NaN.
VOXNAV_INLINE lanes::Ints pixel(lanes::Floats coordinate, int side) {
  using namespace lanes;  // NOLINT: the vector types of this function
  return truncated(smaller(larger(coordinate, Floats{}), Floats{} + static_cast<float>(side - 1)));
}

namespace reference {

struct Projection {
  int face;
  float u, v, scale;
};

/// The face is that of the longest coordinate; the other two, in cyclic order, are scaled by it.
inline Projection project(float x, float y, float z, float half_side) {
  const float p[3] = {x, y, z};
  int axis = 0;
  if (std::abs(y) > std::abs(x)) axis = 1;
  if (std::abs(z) > std::abs(p[axis])) axis = 2;
  const float scale = half_side / std::abs(p[axis]);
  return {2 * axis + (p[axis] < 0.0f ? 1 : 0), p[(axis + 1) % 3] * scale + half_side,
          p[(axis + 2) % 3] * scale + half_side, scale};
}

inline int pixel(float coordinate, int side) {
  if (!(coordinate > 0.0f)) return 0;  // NaN, too
  const auto last = static_cast<float>(side - 1);
  return static_cast<int>(coordinate < last ? coordinate : last);
}

}  // namespace reference
}  // namespace voxnav::kernels::cube_map
