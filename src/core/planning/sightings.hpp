// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planning/other_uavs.hpp"
#include "voxnav/base/time.hpp"
#include "voxnav/containers/moving_thing.hpp"
#include "voxnav/geometry/voxel.hpp"
#include "voxnav/planning/trajectory.hpp"

namespace voxnav::planning {

/// How far ahead the places of moving things are predicted, and how uncertain they become.
struct MovingRules {
  double horizon_s = 0.0;   ///< they are predicted for this time; 0 = not at all
  double growth_mps = 0.0;  ///< the room around them grows by this, beside the uncertainty of their velocity
};

/// What the newest sweep showed in space that the map believes to be free.
struct Sightings {
  base::StampNs stamp_ns = 0;
  /// Voxels with lone returns, which may be drops of rain: too little for the map, and something nevertheless.
  std::vector<geometry::Index3> lone_hits;
  std::vector<containers::MovingThing> things;  ///< in the frame of the view
  MovingRules rules;
  SharedOthers others;  ///< UAVs that announce where they will be; null if there are none

  bool has_nothing_to_meet() const { return things.empty() && (others == nullptr || others->empty()); }
};

/// Returns true if a ball may touch a thing that moves on at constant velocity for a time after its stamp. The thing is
/// an upright cylinder around its box, grown by one standard deviation of its place and by the rules.
bool may_touch(const containers::MovingThing& thing, const MovingRules& rules, double after_s,
               const geometry::Vec3& center, double radius_m);

/// Where a vehicle may meet a thing that moves, or another UAV.
struct Meeting {
  double arc_m = 0.0;    ///< length of the line before it
  double after_s = 0.0;  ///< time after the first point
  geometry::Vec3 place;  ///< of the vehicle
  std::uint32_t id = 0;  ///< of the thing; 0 for another UAV
  std::string name;      ///< of the other UAV; empty for a thing
};

/// A line that is flown: points, and the times after the first one at which they are passed.
struct TimedLine {
  std::vector<geometry::Vec3> points;
  std::vector<double> times_s;
};

/// Returns the part of a trajectory from an arc length on.
TimedLine timed_line(const Trajectory& trajectory, double from_arc_m);

/// Returns the first place at which a ball that moves along a line may touch a thing or another UAV; nothing if it
/// meets none within the time for which they are predicted. O(things * predicted time). After the last point the ball
/// rests there.
/// @param begin_ns  time of the first point
std::optional<Meeting> first_meeting(const Sightings& sightings, const TimedLine& line, base::StampNs begin_ns,
                                     double radius_m);

/// Returns the length of a line before a ball that moves along it first touches one of some voxels; nothing if it does
/// not. O(points * voxels).
std::optional<double> first_touch_m(const std::vector<geometry::Vec3>& line, double radius_m,
                                    const std::vector<geometry::Index3>& voxels, double resolution_m);

}  // namespace voxnav::planning
