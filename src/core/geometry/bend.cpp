// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/geometry/bend.hpp"

namespace voxnav::geometry {

Pose Bend::at(double phase) const {
  const double from_middle = 2.0 * phase - 1.0;
  return from_middle < 0.0 ? interpolate(Pose::Identity(), T_S_begin, -from_middle)
                           : interpolate(Pose::Identity(), T_S_end, from_middle);
}

}  // namespace voxnav::geometry
