// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>

#include "kernels/processor.hpp"

namespace voxnav::kernels {

/// A batch of points of a scan, coordinate by coordinate (structure of arrays), so that one instruction works on
/// several points. Loops always process the whole batch; the entries behind the last point are finite.
struct PointBatch {
  static constexpr std::size_t kSize = 256;
  alignas(32) float x[kSize] = {}, y[kSize] = {}, z[kSize] = {};

  /// Loads at most n points; x y z come first in every `stride` floats. Returns the number of points loaded.
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
