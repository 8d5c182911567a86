// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <type_traits>

namespace voxnav::cloud {

/// One filtered return, in the byte layout of `cloud_filter/points`: it is copied to messages as it stands.
struct Point {
  float x = 0.0F;                    ///< m, sensor frame
  float y = 0.0F;                    ///< m
  float z = 0.0F;                    ///< m
  float intensity = 0.0F;            ///< as the sensor gives it; 0 when it gives none
  std::uint32_t time_offset_ns = 0;  ///< after the start of the sweep
};
static_assert(sizeof(Point) == 20 && std::is_trivially_copyable_v<Point>);

}  // namespace voxnav::cloud
