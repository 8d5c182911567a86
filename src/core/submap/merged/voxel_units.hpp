// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "voxnav/occupancy/map_content.hpp"
#include "voxnav/submap/evidence_map.hpp"

/// Points and lengths in units of 1/254 of a voxel edge, the unit of VoxelPoint::mean. Integer computations give the
/// same result on every machine, and a point on the border of two voxels lies in the upper one in every grid that is
/// aligned.
namespace voxnav::submap {

constexpr int kUnitsPerEdge = 254;
using Units3 = geometry::Index3;
inline int units_of(int voxel, std::int8_t mean) { return voxel * kUnitsPerEdge + kUnitsPerEdge / 2 + mean; }
/// Returns the position of a surface point relative to the corner of its block. An offset is x + 16 y + 256 z.
inline Units3 units_of(const SurfaceEvidence& evidence) {
  const auto& mean = evidence.point.mean;
  return {units_of(evidence.offset & 15, mean[0]), units_of((evidence.offset >> 4) & 15, mean[1]),
          units_of(evidence.offset >> 8, mean[2])};
}
/// Returns that position in voxel edges.
inline geometry::Vec3 local_point(const SurfaceEvidence& evidence) {
  const auto& mean = evidence.point.mean;
  return {(evidence.offset & 15) + 0.5 + mean[0] / 254.0, ((evidence.offset >> 4) & 15) + 0.5 + mean[1] / 254.0,
          (evidence.offset >> 8) + 0.5 + mean[2] / 254.0};
}

/// Fixed-point numbers of units have this many fractional bits.
constexpr int kUnitShift = 32;
/// Converts a length in voxel edges to a fixed-point number of units.
inline std::int64_t fixed_units(double edges) { return std::llround(std::ldexp(edges * kUnitsPerEdge, kUnitShift)); }
/// Returns the voxel in which a fixed-point coordinate, which is not negative, lies.
inline std::uint32_t voxel_at(std::int64_t fixed) {
  return static_cast<std::uint32_t>(fixed >> kUnitShift) / static_cast<std::uint32_t>(kUnitsPerEdge);
}

}  // namespace voxnav::submap
