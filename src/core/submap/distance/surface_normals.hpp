// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "submap/content/content_window.hpp"

namespace voxnav::submap {

/// The orientation of the surface in an occupied voxel.
struct SurfaceNormal {
  geometry::Vec3f normal{0.f, 0.f, 0.f};  ///< unit, towards free space, frame G; zero where nothing free is near
  float quality = 0.f;                    ///< confidence in the normal, 0 to 1
};

/// Estimates the normals of some of the occupied voxels of a window, given by their numbers, from the 26 neighbours of
/// each, which must lie in the window. If the surface points lie in a plane, the normal is that of the plane, else it
/// points to the free voxels.
void estimate_normals(const ContentWindow& window, const std::vector<std::uint16_t>& voxels,
                      std::vector<SurfaceNormal>* normals);

/// Quality of normals of voxels in planes that were seen from one side; their distances are those to the plane.
constexpr float kPlanarQuality = 0.9f;
/// Quality of normals of voxels with free space on one side but without a clear plane.
constexpr float kOneSidedQuality = 0.5f;
/// Quality of such normals if another occupied voxel lies behind: the skin of a solid.
constexpr float kSolidQuality = 0.4f;
/// Quality of normals of voxels with free space all around: thin things.
constexpr float kThinQuality = 0.3f;

}  // namespace voxnav::submap
