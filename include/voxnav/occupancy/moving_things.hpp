// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/base/time.hpp"
#include "voxnav/containers/moving_thing.hpp"
#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::occupancy {

/// Parameters of MovingThings.
struct MovingThingsConfig {
  bool is_enabled = true;
  double min_speed_mps = 0.4;
  double max_speed_mps = 15.0;
  int min_sweeps = 5;
  double max_size_m = 8.0;
  double lost_after_s = 1.0;
  double stands_after_s = 3.0;

  template <class V>
  static void fields(V&& v) {
    using C = MovingThingsConfig;
    v("is_enabled", &C::is_enabled, base::any(), "", "follow things that move, and take what they left out of the map");
    v("min_speed_mps", &C::min_speed_mps, base::in(0.05, 10.0), "m/s", "slower things count as static");
    v("max_speed_mps", &C::max_speed_mps, base::in(0.5, 100.0), "m/s", "nothing that is followed is faster");
    v("min_sweeps", &C::min_sweeps, base::in(3, 100), "",
      "a thing moves once this many sweeps agree about its motion, and it has left the place where it was first seen");
    v("max_size_m", &C::max_size_m, base::in(0.2, 100.0), "m", "larger things are not followed");
    v("lost_after_s", &C::lost_after_s, base::in(0.1, 60.0), "s",
      "a moving thing that is not seen any more is believed to move on for this long");
    v("stands_after_s", &C::stands_after_s, base::in(0.5, 60.0), "s",
      "a thing that has not moved for this long is a part of the static map");
  }
  std::vector<std::string> problems() const;
};

using containers::MovingThing;

/// Finds and follows what moves in a local map: connected hits in space that was believed to be free before, which are
/// displaced from sweep to sweep. A thing moves once its places agree with a constant velocity, and it has left the
/// place where it was first seen, so that a static structure of which more and more is seen is not taken for one.
/// Nor is an apparition that keeps to the vehicle, such as the rings of a sparse sensor on the ground. Hits of moving
/// things are taken back where scans see that they were left (LocalMap::take_back_moving()). Memory is bounded.
class MovingThings {
 public:
  /// @throws base::ConfigError
  explicit MovingThings(const MovingThingsConfig& config);
  ~MovingThings();
  MovingThings(MovingThings&&) noexcept;
  MovingThings& operator=(MovingThings&&) noexcept;

  /// Takes the hits of the scan that was just inserted into the map, and takes back from the map what was left.
  /// @param stamp_ns    of the scan; if it lies far before the last one, everything that was followed is forgotten
  /// @param position    of the vehicle, frame of the map
  /// Work is proportional to the hits in new voxels. Does nothing if it is not enabled.
  void update(LocalMap* map, base::StampNs stamp_ns, const geometry::Vec3& position);
  /// What moves now, by rising id.
  const std::vector<MovingThing>& things() const;
  /// Forgets everything that is followed.
  void clear();
  /// The number of clusters of hits that were not followed because there were too many.
  std::size_t num_not_followed() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voxnav::occupancy
