// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "submap/content/compressed_field.hpp"
#include "voxnav/geometry/distance_field.hpp"

namespace voxnav::submap {

/// At most `max_points` surface points, frame S, spread evenly: rounds over cells of 4^3 voxels, each giving its next
/// best leaf (normal quality, then hits). Deterministic, depends on nothing but the field.
std::vector<geometry::SurfacePoint> sample_surface(const CompressedField& field, double resolution_m,
                                                   const geometry::Pose& T_S_G, int max_points);
/// The same with normals that were measured (projective filling).
std::vector<geometry::SurfacePoint> sample_surface(const std::vector<FilledBlock>& blocks, double resolution_m,
                                                   const geometry::Pose& T_S_G, int max_points);

}  // namespace voxnav::submap
