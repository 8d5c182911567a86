// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

namespace voxnav::bindings {

void bind_mapper(pybind11::module_& m);

}  // namespace voxnav::bindings
