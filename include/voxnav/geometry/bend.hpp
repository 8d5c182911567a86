// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/geometry/pose.hpp"

namespace voxnav::geometry {

/// What drift did to a submap while it was made. Its pose holds for its middle; what it saw when it began has to be
/// moved by T_S_begin to lie as its middle does, what it saw when it ended by T_S_end, and what it saw in between by a
/// share of them. Identities leave it rigid.
struct Bend {
  Pose T_S_begin = Pose::Identity();
  Pose T_S_end = Pose::Identity();

  bool is_rigid() const {
    return T_S_begin.matrix() == Pose::Identity().matrix() && T_S_end.matrix() == Pose::Identity().matrix();
  }
  /// @param phase  share of the submap's time, 0 to 1
  Pose at(double phase) const;
};

}  // namespace voxnav::geometry
