// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "submap/content/content_window.hpp"
#include "submap/distance/surface_normals.hpp"

namespace voxnav::submap {

/// Returns the signed distance at the centre of an occupied voxel of a window. If the surface was seen from one side,
/// it is the distance to the plane through the surface point, so that the zero level runs through the measured points.
/// Otherwise it is half an edge minus the distance to the nearest free centre; it is minus half an edge if no free
/// voxel is beside the voxel and it is not enclosed by occupied ones.
/// @param i     number of the voxel in the window
/// @param band  the distance is -band where it would be lower
float occupied_distance(const ContentWindow& window, std::size_t i, const SurfaceNormal& normal, float band);

}  // namespace voxnav::submap
