// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "voxnav/base/time.hpp"
#include "voxnav/containers/moving_thing.hpp"
#include "voxnav/geometry/aabb.hpp"

namespace voxnav::planning {

using containers::OtherUav;
using SharedOthers = std::shared_ptr<const std::vector<OtherUav>>;

/// @throws std::invalid_argument if it has no places, or a number that is not finite or negative
void require_valid(const OtherUav& other);

/// The last time for which another UAV is to be kept clear of.
base::StampNs horizon_ns(const OtherUav& other);

/// Returns where another UAV is believed to be at a time. Before its first place and after its last one it is there.
geometry::Vec3 place_at(const OtherUav& other, base::StampNs at_ns);

/// Returns the radius of a ball around that place in which it is.
double radius_at(const OtherUav& other, base::StampNs at_ns);

/// Returns true if a ball may touch another UAV at a time.
bool may_touch(const OtherUav& other, base::StampNs at_ns, const geometry::Vec3& center, double radius_m);

/// When the vehicle may be somewhere, if it flies there from where it is now.
struct Arrival {
  base::StampNs now_ns;
  geometry::Vec3 vehicle;
  double speed_mps;  ///< at which it may fly; at most

  base::StampNs earliest_ns(const geometry::Vec3& place) const;
  base::StampNs latest_ns(const geometry::Vec3& place) const;
};

/// The balls in which another UAV will be within its horizon, at steps of time: what a search keeps clear of.
class OtherUavTrack {
 public:
  OtherUavTrack(const OtherUav& other, base::StampNs now_ns, double clearance_m);

  const geometry::Aabb& box() const { return box_; }
  /// The part of the track that reaches a box; empty if none does.
  OtherUavTrack within(const geometry::Aabb& box) const;
  bool empty() const { return balls_.empty(); }
  /// Returns true if the vehicle may be at a place while the other UAV is too near to it.
  bool may_meet(const Arrival& arrival, const geometry::Vec3& place) const;

 private:
  struct Ball {
    base::StampNs at_ns;
    geometry::Vec3 center;
    double radius_m;
  };
  OtherUavTrack() = default;
  void add(const Ball& ball);

  std::vector<Ball> balls_;
  geometry::Aabb box_;
};

}  // namespace voxnav::planning
