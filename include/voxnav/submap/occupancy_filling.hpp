// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/occupancy/map_content.hpp"
#include "voxnav/submap/field_block.hpp"
#include "voxnav/submap/submap_config.hpp"

namespace voxnav::submap {

/// Distances for everything the local map knows, without casting a ray, so that nothing thin is carved away:
///  - free voxels: exact distance of their centre to the nearest surface point (mean of hits of an occupied leaf);
///  - occupied voxels seen from one side: signed distance to the plane through their surface point, so that the zero
///    level runs through the points that were measured; all others: -(distance to the nearest free centre - half an
///    edge), or minus half an edge where nothing free is beside it and it is not enclosed by occupied voxels;
///  - unknown voxels beside an occupied one: signed distance to its plane. They stay unknown and only serve
///    interpolation inside the known voxels next to them.
/// Exact to float rounding within the band; error of inside values at most half an edge. O(leaves * band^3).
/// Source: algorithms.md section 5 (occupancy to distance), exact within the band as in
/// Felzenszwalb & Huttenlocher 2012, but with surface points below voxel size.
/// @throws std::invalid_argument when leaves and states of the content do not match
std::vector<FilledBlock> fill_from_occupancy(const occupancy::MapContent& content, const SubmapConfig& config);

/// Surface normals of all leaves from their neighbours (26-neighbourhood), oriented towards free space.
void estimate_normals(std::vector<FilledBlock>* blocks);

/// Leaves in planes seen from one side; their distances are taken from the plane.
constexpr float kPlanarQuality = 0.9f;
/// Leaves with free space on one side but no clear plane.
constexpr float kOneSidedQuality = 0.5f;
/// The same in front of another occupied voxel: the skin of a solid.
constexpr float kSolidQuality = 0.4f;
/// Leaves with free space all around: thin things.
constexpr float kThinQuality = 0.3f;

}  // namespace voxnav::submap
