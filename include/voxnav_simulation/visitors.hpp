// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "voxnav_simulation/movers.hpp"

namespace voxnav_simulation {

/// Other simulated UAVs that fly in the same world, as their simulators tell where they are. Thread-safe.
class Visitors {
 public:
  /// Takes the place of the middle of a UAV. A stamp that is not newer than the last one is from a simulation that
  /// began anew, and the places before it are forgotten. Places that are not finite are left out.
  void note(const std::string& name, voxnav::base::StampNs stamp_ns, const Vec3& middle);
  /// Returns the shape of each visitor and the middle of its bottom at a time, by name. Between known places they fly
  /// straight; after the last one they fly on for a short time.
  std::vector<std::pair<const Mover*, Vec3>> at(voxnav::base::StampNs stamp_ns) const;

 private:
  using Places = std::vector<std::pair<voxnav::base::StampNs, Vec3>>;

  mutable std::mutex mutex_;
  std::map<std::string, Places> places_;
};

}  // namespace voxnav_simulation
