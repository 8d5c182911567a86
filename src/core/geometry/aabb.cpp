// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/geometry/aabb.hpp"

namespace voxnav::geometry {

Aabb Aabb::transformed(const Pose& T_A_B) const {
  Aabb out;
  if (empty()) return out;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p_B((corner & 1) ? max.x() : min.x(), (corner & 2) ? max.y() : min.y(),
                   (corner & 4) ? max.z() : min.z());
    out.extend(T_A_B * p_B);
  }
  return out;
}

}  // namespace voxnav::geometry
