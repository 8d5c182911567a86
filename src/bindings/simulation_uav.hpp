// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pybind.hpp"

namespace voxnav::bindings {

/// The vehicle's half of voxnav._simulation.
void bind_uav(pybind11::module_& m);

}  // namespace voxnav::bindings
