// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/base/lanes.hpp"

/// Eight rays at once. No branch depends on a single ray: which axis it follows, and where it changes voxel next,
/// nobody could predict.
namespace voxnav::occupancy::ray_walk {

using namespace base::lanes;  // NOLINT: the vector types of this file

constexpr std::int32_t kNever = 1 << 30;

/// What follows for each ray from which axis is its longest.
struct Choice {
  Ints is_x, is_y;
  template <class V>
  VOXNAV_INLINE V of(V x, V y, V z) const {
    return is_x ? x : is_y ? y : z;
  }
};

/// Rays from the end with the smaller coordinate on the longest axis to the other one.
struct Ends {
  Floats from_a, from_b, from_c, to_a, to_b, to_c;
};

/// The way across one of the two shorter axes: where on the longest one, in fixed point, the next change of voxel
/// comes, how far they are apart, and what a change does to the line.
struct ShortAxis {
  Ints next, per_cell, step;
};

VOXNAV_INLINE ShortAxis short_axis(Floats from, Floats to, Floats from_a, Floats length_a, Ints step, float one) {
  const Ints cell = truncated(from);
  const Ints is_up = to >= from;
  const Ints stays = truncated(to) == cell;
  const float most = static_cast<float>(kNever) / one;
  const Floats way = absolute(to - from);
  const Floats per_cell = smaller(length_a / (way > 0.0f ? way : way + 1.0f), Floats{} + most);
  const Floats first = is_up ? floats(cell + 1) - from : from - floats(cell);
  const Ints next = truncated(smaller(from_a + first * per_cell, Floats{} + most) * one);
  return {stays ? Ints{} + kNever : next, truncated(per_cell * one + 0.5f), is_up ? step : -step};
}

}  // namespace voxnav::occupancy::ray_walk
