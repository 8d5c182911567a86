// SPDX-License-Identifier: BSD-3-Clause
#include "floors.hpp"

namespace voxnav::bindings {

void bind_submap(pybind11::module_&) {}

}  // namespace voxnav::bindings
