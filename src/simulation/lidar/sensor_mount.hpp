// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "voxnav_simulation/mesh.hpp"

namespace voxnav_simulation {

/// Pose on the body of a sensor whose configuration gives position, and fixed-axis roll, pitch and yaw.
Pose sensor_mount(const std::array<double, 3>& position_m, const std::array<double, 3>& rpy_rad);

}  // namespace voxnav_simulation
