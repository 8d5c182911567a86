// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/tracker.hpp"

namespace voxnav_simulation {

/// Section `safety_area` of the simulated control manager: a prism outside of which references are refused and
/// trajectories are cut (mrs_uav_managers/src/control_manager/control_manager.cpp: setTrajectoryReference).
struct SafetyAreaConfig {
  bool is_enabled = false;
  std::vector<double> points_m{-50.0, -50.0, 50.0, -50.0, 50.0, 50.0, -50.0, 50.0};
  double min_z_m = -100.0;
  double max_z_m = 15.0;

  template <class V>
  static void fields(V&& v) {
    using C = SafetyAreaConfig;
    using voxnav::base::any;
    using voxnav::base::in;
    v("is_enabled", &C::is_enabled, any(), "", "the control manager has a safety area");
    v("points_m", &C::points_m, any(), "m", "its border: x y of each corner, in the frame of the first estimator");
    v("min_z_m", &C::min_z_m, in(-1e4, 1e4), "m", "its lowest height there");
    v("max_z_m", &C::max_z_m, in(-1e4, 1e4), "m", "its greatest height there");
  }
  std::vector<std::string> problems() const;
};

/// @param p  in the frame of the first estimator
bool is_inside(const SafetyAreaConfig& area, const Vec3& p);

/// Which limits of the area count: the control manager also answers for the border alone, whatever the height.
enum class SafetyLimits { kBorder, kBorderAndHeights };

/// @param p  in the frame of the first estimator
bool is_inside(const SafetyAreaConfig& area, const Vec3& p, SafetyLimits limits);
/// Whether the straight way between two places is inside (mrs_lib/src/safety_zone: isPathValid).
bool is_way_inside(const SafetyAreaConfig& area, const Vec3& from, const Vec3& to, SafetyLimits limits);

struct SafetyVerdict {
  std::string refusal;       ///< why the trajectory is refused; empty if it is not
  bool is_modified = false;  ///< whether its tail was cut, so that it ends at its last point inside
};

/// Cuts the tail of a trajectory from its first point outside on. One that begins outside is refused.
SafetyVerdict keep_inside(const SafetyAreaConfig& area, TrackedTrajectory* trajectory);

}  // namespace voxnav_simulation
