// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pybind.hpp"

namespace voxnav::bindings {

/// Binds prisms and the fences that are made of them; part of bind_planning().
void bind_fences(pybind11::module_& m);

}  // namespace voxnav::bindings
