// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "submap/content/content_window.hpp"
#include "submap/distance/surface_normals.hpp"

namespace voxnav::submap {

/// Signed distance at the centre of an occupied voxel of a window: to the plane through its surface point where it was
/// seen from one side, so that the zero level runs through the points that were measured. Others get minus the distance
/// to the nearest free centre but half an edge, or minus half an edge where nothing free is beside the voxel and it is
/// not enclosed by occupied ones.
/// @param i  the voxel by its number in the window  @param band  what lies deeper gets minus this
float occupied_distance(const ContentWindow& window, std::size_t i, const SurfaceNormal& normal, float band);

}  // namespace voxnav::submap
