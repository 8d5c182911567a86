// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/dynamics_limits.hpp"
#include "voxnav_simulation/kinematic_state.hpp"

namespace voxnav_simulation {

/// Section `bumper`. The MRS control manager disables callbacks and flies away from obstacles that the ranges in eight
/// horizontal sectors, below and above show too near (mrs_uav_managers/config/public/control_manager.yaml:
/// obstacle_bumper; config/private/control_manager.yaml: rate and overshoot; src/control_manager/control_manager.cpp:
/// bumperPushFromObstacle).
struct BumperConfig {
  bool is_enabled = false;
  bool heeds_sectors = false;
  double min_distance_m = 1.2;
  double overshoot_m = 0.2;
  bool is_derived_from_dynamics = true;
  int num_sectors = 8;
  double vertical_fov_rad = 0.35;

  template <class V>
  static void fields(V&& v) {
    using C = BumperConfig;
    using voxnav::base::in;
    v("is_enabled", &C::is_enabled, voxnav::base::any(), "", "the control manager flies away from near obstacles");
    v("heeds_sectors", &C::heeds_sectors, voxnav::base::any(), "",
      "obstacles are those that bumper/obstacle_sectors tells of, as in MRS; false: the true ones around the vehicle");
    v("min_distance_m", &C::min_distance_m, in(0.1, 20), "m", "obstacles nearer than this repel");
    v("overshoot_m", &C::overshoot_m, in(0, 5), "m", "the vehicle is pushed this much farther away, horizontally");
    v("is_derived_from_dynamics", &C::is_derived_from_dynamics, voxnav::base::any(), "",
      "that distance grows by 1.5 times the way to stop from the speed limit, which keeps away from forests");
    v("num_sectors", &C::num_sectors, in(4, 64), "", "horizontal sectors, of which the first looks ahead");
    v("vertical_fov_rad", &C::vertical_fov_rad, in(0, 1.5), "rad", "angle of view of the sectors from top to bottom");
  }
};

/// What a message of obstacle sectors tells: ranges in horizontal sectors, counter-clockwise from the front, below and
/// above; nothing where there is no obstacle, or where nothing is known.
struct SectorRanges {
  std::vector<std::optional<double>> horizontal_m;
  std::optional<double> below_m, above_m;
};

/// Decides when and where obstacles push the vehicle.
class Bumper {
 public:
  /// Returns the range along a unit direction, or nothing if nothing is closer than `max_m`.
  using Range = std::function<std::optional<double>(const Vec3& direction, double max_m)>;

  /// @throws voxnav::base::ConfigError
  explicit Bumper(const BumperConfig& config);

  bool is_enabled() const { return config_.is_enabled; }
  bool heeds_sectors() const { return config_.heeds_sectors; }
  /// Returns the way that the vehicle is to move, or nothing if no obstacle is too near.
  std::optional<Vec3> push(const Range& range, double heading_rad, const TrackerLimits& limits) const;
  std::optional<Vec3> push(const SectorRanges& sectors, double heading_rad, const TrackerLimits& limits) const;

 private:
  struct Reach {
    double across_m, along_m;  ///< obstacles nearer than this repel, horizontally and vertically
  };
  Reach reach(const TrackerLimits& limits) const;
  std::optional<Vec3> push(const SectorRanges& sectors, double heading_rad, const Reach& near) const;
  std::optional<double> sector_range(const Range& range, double direction_rad, double max_m) const;

  BumperConfig config_;
};

}  // namespace voxnav_simulation
