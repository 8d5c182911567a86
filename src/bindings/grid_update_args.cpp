// SPDX-License-Identifier: BSD-3-Clause
#include "grid_update_args.hpp"

namespace voxnav::bindings {
namespace {

/// Blocks as a message carries them; flat lists of integers, as rospy gives them, are accepted too.
std::vector<std::int32_t> block_list(const py::object& indices, const char* name) {
  const auto array = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>::ensure(indices);
  if (!array) {
    PyErr_Clear();
    throw py::value_error(std::string(name) + " must be integers, x y z per block");
  }
  return {array.data(), array.data() + array.size()};
}

}  // namespace

containers::GridUpdate grid_update_from(const py::object& block_indices, const py::buffer& states,
                                        const py::object& removed, bool is_snapshot) {
  const py::buffer_info bytes = states.request();
  if (bytes.itemsize != 1) throw py::value_error("states must be bytes or a uint8 array");
  containers::GridUpdate update;
  update.is_snapshot = is_snapshot;
  update.block_indices = block_list(block_indices, "block_indices");
  update.removed_block_indices = block_list(removed, "removed");
  const auto* data = static_cast<const std::uint8_t*>(bytes.ptr);
  update.states.assign(data, data + bytes.size);
  return update;
}

}  // namespace voxnav::bindings
