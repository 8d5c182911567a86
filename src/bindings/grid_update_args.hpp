// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"
#include "voxnav/containers/state_grid.hpp"

namespace voxnav::bindings {

/// A GridUpdate from the fields of its message; flat lists of integers, as rospy gives them, are accepted too.
/// @throws py::value_error
containers::GridUpdate grid_update_from(const py::object& block_indices, const py::buffer& states,
                                        const py::object& removed, bool is_snapshot);

}  // namespace voxnav::bindings
