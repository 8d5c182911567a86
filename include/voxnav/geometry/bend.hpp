// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/geometry/pose.hpp"

namespace voxnav::geometry {

/// The drift within a submap while it was made. The pose of a submap holds for the middle of its time. What it observed
/// at its beginning has to be moved by T_S_begin to lie where it would lie without drift against the middle, what it
/// observed at its end by T_S_end, and what it observed in between by an interpolation. With identities the submap is
/// rigid. docs/maths/submaps.md, section Bend, has the formula.
struct Bend {
  Pose T_S_begin = Pose::Identity();
  Pose T_S_end = Pose::Identity();

  bool is_rigid() const {
    return T_S_begin.matrix() == Pose::Identity().matrix() && T_S_end.matrix() == Pose::Identity().matrix();
  }
  /// Returns the motion at a phase. @param phase  0 at the submap's beginning, 1 at its end
  Pose at(double phase) const;
};

}  // namespace voxnav::geometry
