// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace voxnav::test {

/// Returns first, first + step, first + 2 step, ... below `end`. They are counted, so that no error of rounding adds
/// up.
inline std::vector<double> steps(double first, double end, double step) {
  const auto count = static_cast<std::size_t>(std::ceil((end - first) / step - 1e-9));
  std::vector<double> out(count);
  for (std::size_t i = 0; i < count; ++i) out[i] = first + static_cast<double>(i) * step;
  return out;
}

}  // namespace voxnav::test
