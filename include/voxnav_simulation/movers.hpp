// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "voxnav/base/time.hpp"
#include "voxnav_simulation/terrain.hpp"

namespace voxnav_simulation {

/// An upright cylinder that goes round along a closed line at constant speed: a person, or another UAV.
struct Mover {
  SurfaceClass surface_class = SurfaceClass::kPerson;
  double radius_m = 0;
  double height_m = 0;
  double speed_mps = 0;
  double spacing_m = 0;    ///< between neighbours of the line
  std::vector<Vec3> line;  ///< middles of the cylinder's bottom, evenly spaced; the last is followed by the first
  double begin_m = 0;      ///< place along the line at stamp 0

  /// Returns the middle of its bottom at a time.
  Vec3 at(voxnav::base::StampNs stamp_ns) const;
};

/// Returns what another UAV looks like, without a way.
Mover flyer();

/// Returns the range to a cylinder along a unit direction, with the cosine of incidence; nothing if the ray misses it.
/// A ray from inside meets nothing.
struct CylinderHit {
  double range_m;
  double cos_incidence;
};
std::optional<CylinderHit> cast_at_cylinder(const Mover& mover, const Vec3& bottom, const Vec3& origin,
                                            const Vec3& direction);
/// Returns the distance from a point to the cylinder; 0 inside.
double distance_to_cylinder(const Mover& mover, const Vec3& bottom, const Vec3& p);

/// Makes the persons and UAVs of a world: those whose way points its configuration lists, and those that the seed
/// places across the line from start to goal.
std::vector<Mover> make_movers(const WorldConfig& config, std::uint64_t seed, const Terrain& terrain);

}  // namespace voxnav_simulation
