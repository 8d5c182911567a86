// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pybind.hpp"

namespace voxnav::bindings {

void bind_moving_things(pybind11::module_& m);

}  // namespace voxnav::bindings
