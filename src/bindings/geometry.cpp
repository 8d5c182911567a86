// SPDX-License-Identifier: BSD-3-Clause
#include "floors.hpp"

namespace voxnav::bindings {

void bind_geometry(pybind11::module_&) {}

}  // namespace voxnav::bindings
