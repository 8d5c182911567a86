// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>

#include "kernels/processor.hpp"

namespace voxnav::kernels {

/// Some points of a scan, coordinate by coordinate, so that one instruction works on several of them. Loops over a
/// batch always take all of it; what lies behind the last point is finite.
struct PointBatch {
  static constexpr std::size_t kSize = 256;
  alignas(32) float x[kSize] = {}, y[kSize] = {}, z[kSize] = {};

  /// Takes at most n points; x y z come first in every `stride` floats. Returns how many it took.
  VOXNAV_INLINE std::size_t load(const float* points, std::size_t n, std::size_t stride) {
    n = std::min(n, kSize);
    for (std::size_t i = 0; i < n; ++i, points += stride) {
      x[i] = points[0];
      y[i] = points[1];
      z[i] = points[2];
    }
    return n;
  }
};

}  // namespace voxnav::kernels
