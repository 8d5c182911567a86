// SPDX-License-Identifier: BSD-3-Clause
#include "floors.hpp"
#include "planning_manager.hpp"

namespace voxnav::bindings {

void bind_pipeline(pybind11::module_& m) { bind_planning_manager(m); }

}  // namespace voxnav::bindings
