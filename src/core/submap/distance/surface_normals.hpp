// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "submap/content/content_window.hpp"

namespace voxnav::submap {

/// The surface in a voxel.
struct SurfaceNormal {
  geometry::Vec3f normal{0.f, 0.f, 0.f};  ///< unit, towards free space, frame G; zero where nothing free is near
  float quality = 0.f;                    ///< confidence in the normal, 0 to 1
};

/// Normals of some of the occupied voxels of a window, by number, from the 26 voxels around each; these must lie in the
/// window. Where the surface points lie in a plane it is theirs, else it points to the free voxels.
void estimate_normals(const ContentWindow& window, const std::vector<std::uint16_t>& voxels,
                      std::vector<SurfaceNormal>* normals);

/// Quality of voxels in planes that were seen from one side; their distances are taken from the plane.
constexpr float kPlanarQuality = 0.9f;
/// Quality of voxels with free space on one side but no clear plane.
constexpr float kOneSidedQuality = 0.5f;
/// The same in front of another occupied voxel: the skin of a solid.
constexpr float kSolidQuality = 0.4f;
/// Quality of voxels with free space all around: thin things.
constexpr float kThinQuality = 0.3f;

}  // namespace voxnav::submap
