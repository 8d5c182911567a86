// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/geometry/distance_field.hpp"

namespace voxnav::graph {

/// Finds the landmarks among the surface points of a submap, frame S: the feet of upright things (trunks, poles,
/// corners of walls). A landmark is a column of a horizontal grid with points on at least five of the eight half metres
/// from 0.5 m above the ground around it. The number of landmarks is bounded. O(n log n); deterministic.
std::vector<geometry::Vec3> landmarks_of(const std::vector<geometry::SurfacePoint>& points);

}  // namespace voxnav::graph
