// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>

#include <vector>

#include "pybind.hpp"
#include "voxnav/submap/mesh.hpp"

namespace voxnav::bindings {

void bind_submap_collection(pybind11::module_& m);

/// (k, 3) float32.
pybind11::array_t<float> rows_of(const std::vector<geometry::Vec3f>& points);
/// (vertices (k, 3) float32, triangles (t, 3) uint32).
pybind11::tuple mesh_tuple(const submap::Mesh& mesh);

}  // namespace voxnav::bindings
