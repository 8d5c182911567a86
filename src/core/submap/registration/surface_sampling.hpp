// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "submap/content/submap_content.hpp"
#include "submap/distance/surface_normals.hpp"
#include "voxnav/geometry/distance_field.hpp"

namespace voxnav::submap {

/// Chooses at most `max_points` surface points, frame S, that are spread evenly: in rounds over cells of 4^3 voxels,
/// each cell gives its next best point (by quality of the normal, then by hits). Deterministic; the result depends on
/// nothing but the content.
std::vector<geometry::SurfacePoint> sample_surface(const SubmapContent& content, double resolution_m,
                                                   const geometry::Pose& T_S_G, int max_points);
/// Chooses surface points with normals that were measured by rays (projective filling).
/// @param normals  normals of the occupied voxels of each block of the content
std::vector<geometry::SurfacePoint> sample_surface(const occupancy::MapContent& content,
                                                   const std::vector<std::vector<SurfaceNormal>>& normals,
                                                   const geometry::Pose& T_S_G, int max_points);

}  // namespace voxnav::submap
