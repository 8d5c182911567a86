// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

/// The one place that knows which pybind11 it is: 2.4 (Ubuntu 20.04) has no module_, later ones have both names.
#if PYBIND11_VERSION_MAJOR == 2 && PYBIND11_VERSION_MINOR < 6
namespace pybind11 {
using module_ = module;
}  // namespace pybind11
#endif
