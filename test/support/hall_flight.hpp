// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "room_world.hpp"
#include "voxnav/cloud/sweep.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::test {

using Motion = std::function<geometry::Pose(double)>;

inline base::StampNs stamp_of(double t) { return base::from_seconds(1000.0 + t); }

inline geometry::Pose line(double t) { return geometry::from_position_yaw(geometry::Vec3(1.5 * t, 0, 0), 0.4 * t); }

/// What a LiDAR with this motion sees of the hall in a turn that begins at `t`.
inline cloud::Sweep sweep_at(double t, const Motion& motion = line) {
  const RoomSweep seen = sweep_of(RoomWorld::hall(), motion, t, 0.0, 1);
  cloud::Sweep out;
  out.stamp_ns = out.start_ns = stamp_of(t);
  out.points = seen.points_L;
  for (const float time_s : seen.times_s) {
    out.time_offsets_ns.push_back(static_cast<std::uint32_t>(std::lround(time_s * 1e9)));
    out.duration_ns = std::max(out.duration_ns, out.time_offsets_ns.back());
  }
  return out;
}

/// Distance of a point from the nearest surface of the hall.
inline double hall_distance_m(const geometry::Vec3& p) {
  const RoomWorld world = RoomWorld::hall();
  double nearest = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    nearest = std::min({nearest, std::abs(p[axis] - world.room.min[axis]), std::abs(p[axis] - world.room.max[axis])});
  }
  for (const geometry::Aabb& box : world.boxes) {
    nearest = std::min(nearest, (p - p.cwiseMax(box.min).cwiseMin(box.max)).norm());
  }
  return nearest;
}

}  // namespace voxnav::test
