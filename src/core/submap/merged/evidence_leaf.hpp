// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::submap {

/// A surface point in a block of the map frame W.
struct PlacedLeaf {
  std::uint16_t offset;             ///< geometry::offset_in_block() of its voxel
  std::array<std::int8_t, 3> mean;  ///< from the voxel centre, unit voxel edge / 254
  std::uint8_t hits;                ///< its weight: scans that hit it
  std::uint8_t range;  ///< from where it was seen: half metres, rounded down; 255 = that or more, or unknown
  bool is_thin;        ///< no surface goes through it: a wire, a pole, a twig

  /// At least as near somebody was.
  double range_m() const { return range == 255 ? 0.0 : 0.5 * range; }
};

/// One that is believed.
struct EvidenceLeaf : PlacedLeaf {
  std::uint32_t submap_id;
  bool is_new;      ///< an older submap had seen free space here
  bool is_doubted;  ///< a newer submap has seen free space here, which alone proves nothing
};

/// Of a leaf, in voxel edges from the corner of its block.
inline geometry::Vec3 local_point(const PlacedLeaf& leaf) {
  return {(leaf.offset & 15) + 0.5 + leaf.mean[0] / 254.0, ((leaf.offset >> 4) & 15) + 0.5 + leaf.mean[1] / 254.0,
          (leaf.offset >> 8) + 0.5 + leaf.mean[2] / 254.0};
}

/// Points and lengths in units of means, 254 to a voxel edge: what is computed from them in integers is the same on
/// every machine, and points on the border of two voxels lie in the upper one wherever grids fit each other.
constexpr int kUnitsPerEdge = 254;
using Units3 = geometry::Index3;
inline int units_of(int voxel, std::int8_t mean) { return voxel * kUnitsPerEdge + kUnitsPerEdge / 2 + mean; }
/// Of a leaf, from the corner of its block.
inline Units3 units_of(const PlacedLeaf& leaf) {
  return {units_of(leaf.offset & 15, leaf.mean[0]), units_of((leaf.offset >> 4) & 15, leaf.mean[1]),
          units_of(leaf.offset >> 8, leaf.mean[2])};
}

/// A part of a unit: 32 bits behind the point.
constexpr int kUnitShift = 32;
/// Of a length in voxel edges.
inline std::int64_t fixed_units(double edges) { return std::llround(std::ldexp(edges * kUnitsPerEdge, kUnitShift)); }
/// Voxel of such a coordinate from 0 on.
inline std::uint32_t voxel_at(std::int64_t fixed) {
  return static_cast<std::uint32_t>(fixed >> kUnitShift) / static_cast<std::uint32_t>(kUnitsPerEdge);
}

}  // namespace voxnav::submap
