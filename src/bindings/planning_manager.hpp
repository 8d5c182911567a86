// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pybind.hpp"

namespace voxnav::bindings {

/// Part of the pipeline floor: NavigationMap, the planning manager and its jobs.
void bind_navigation_map(pybind11::module_& m);
void bind_planning_manager(pybind11::module_& m);

}  // namespace voxnav::bindings
