// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "occupancy/moving/hit_clusters.hpp"
#include "voxnav/occupancy/moving_things.hpp"

namespace voxnav::occupancy {

/// A place of a thing at constant velocity, fitted to where it was seen lately.
struct MotionFit {
  std::size_t num_sightings = 0;
  geometry::Vec3 center = geometry::Vec3::Zero();  ///< at the last sighting
  geometry::Vec3 velocity = geometry::Vec3::Zero();
  double rms_m = 0.0;  ///< of the distances of the sightings from the fitted places
  double velocity_sigma_mps = 0.0;
};

/// One thing that may move, followed from sweep to sweep.
class FollowedThing {
 public:
  FollowedThing(std::uint32_t id, base::StampNs stamp_ns, const HitCluster& cluster);

  /// Where hits of the thing are to be expected at a stamp, and where its middle is.
  geometry::Aabb expected_box(base::StampNs stamp_ns) const;
  geometry::Vec3 expected_center(base::StampNs stamp_ns) const;
  /// Whether a thing of this size may have the given box.
  bool may_have(const geometry::Aabb& box, double max_size_m) const;
  /// Takes the hits of a sweep.
  void see(base::StampNs stamp_ns, const HitCluster& cluster);

  /// Whether the thing agrees with a motion of its own, by which it has left a place where it was seen.
  /// @param vehicle_velocity  what keeps to the vehicle is no thing
  bool agrees_to_move(const MovingThingsConfig& config, const geometry::Vec3& vehicle_velocity) const;
  /// Whether it has stayed where it is for so long.
  bool stands(base::StampNs stamp_ns, double after_s) const;
  const geometry::Aabb& seen_box() const { return sightings_.back().box; }
  double unseen_s(base::StampNs stamp_ns) const { return base::to_seconds(stamp_ns - sightings_.back().stamp_ns); }
  MovingThing thing_at(base::StampNs stamp_ns) const;

  std::uint32_t id = 0;
  bool is_moving = false;
  std::vector<geometry::Index3> voxels;  ///< that were hit before it was known to move; bounded

 private:
  struct Sighting {
    base::StampNs stamp_ns;
    geometry::Vec3 center;
    geometry::Aabb box;
    int num_returns;
  };
  bool has_left(const Sighting& earlier) const;
  bool is_body() const;
  /// Half the size of the largest boxes in which it was seen lately.
  geometry::Vec3 half_size_m() const;

  std::deque<Sighting> sightings_;  ///< the newest last; bounded
  MotionFit fit_;
  geometry::Vec3 rest_center_;
  base::StampNs moved_ns_;
};

}  // namespace voxnav::occupancy
