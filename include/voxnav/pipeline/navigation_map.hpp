// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/base/time.hpp"
#include "voxnav/containers/moving_thing.hpp"
#include "voxnav/containers/state_grid.hpp"
#include "voxnav/planning/fences.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {
class FenceRaster;
}

namespace voxnav::pipeline {

class PlacedObstacles;
class PlacedSightings;
class TerrainSource;

struct NavigationMapConfig {
  double min_altitude_m = 0.5;
  double max_altitude_m = 50.0;
  double min_height_m = 0.0;
  double max_height_m = 0.0;
  double range_m = 150.0;
  double footprint_radius_m = 1.2;
  double footprint_half_height_m = 1.2;
  bool local_knows_better = true;
  bool use_new_hits = true;
  double moving_horizon_s = 2.5;
  double moving_growth_mps = 0.2;
  double moving_clearance_m = 1.0;
  double meeting_speed_mps = 4.0;
  double area_margin_m = 0.4;
  double zone_distance_m = 1.0;

  template <class V>
  static void fields(V&& v) {
    v("min_altitude_m", &NavigationMapConfig::min_altitude_m, base::in(-1000.0, 9000.0), "m",
      "lowest altitude of a path in the map frame");
    v("max_altitude_m", &NavigationMapConfig::max_altitude_m, base::in(-1000.0, 9000.0), "m",
      "highest altitude of a path in the map frame");
    v("min_height_m", &NavigationMapConfig::min_height_m, base::in(0.0, 9000.0), "m",
      "lowest height of a path above the terrain, where the local map shows it; 0 = no limit");
    v("max_height_m", &NavigationMapConfig::max_height_m, base::in(0.0, 9000.0), "m",
      "highest height of a path above the terrain, where the local map shows it; 0 = no limit");
    v("range_m", &NavigationMapConfig::range_m, base::in(10.0, 2000.0), "m",
      "paths stay this near to the vehicle on both horizontal axes");
    v("footprint_radius_m", &NavigationMapConfig::footprint_radius_m, base::in(0.0, 10.0), "m",
      "unknown voxels this near to the vehicle count as free, horizontally: it is there, and its LiDAR cannot see "
      "them");
    v("footprint_half_height_m", &NavigationMapConfig::footprint_half_height_m, base::in(0.0, 10.0), "m",
      "as footprint_radius_m, up and down");
    v("local_knows_better", &NavigationMapConfig::local_knows_better, base::any(), "",
      "obstacles of the global map give way where the local map knows everything within the safety distance");
    v("use_new_hits", &NavigationMapConfig::use_new_hits, base::any(), "",
      "what one sweep shows in free space counts at once, before the map believes it");
    v("moving_horizon_s", &NavigationMapConfig::moving_horizon_s, base::in(0.0, 10.0), "s",
      "the flight keeps clear of where moving things will be within this time; 0 = of where they are only");
    v("moving_growth_mps", &NavigationMapConfig::moving_growth_mps, base::in(0.0, 5.0), "m/s",
      "the room that moving things may need grows by this, beside the uncertainty of their velocity");
    v("moving_clearance_m", &NavigationMapConfig::moving_clearance_m, base::in(0.0, 10.0), "m",
      "distance of paths from where moving things and other UAVs may be");
    v("meeting_speed_mps", &NavigationMapConfig::meeting_speed_mps, base::in(0.2, 30.0), "m/s",
      "speed at which a search believes the vehicle to fly when it keeps clear of where other UAVs will be by then");
    v("area_margin_m", &NavigationMapConfig::area_margin_m, base::in(0.0, 20.0), "m",
      "planned paths stay this far inside the safety area, at its sides as below and above; what is flown stays "
      "inside");
    v("zone_distance_m", &NavigationMapConfig::zone_distance_m, base::in(0.0, 20.0), "m",
      "planned paths stay this far from no-fly zones; what is flown keeps corridor_radius_m");
  }
  std::vector<std::string> problems() const;
};

/// What the newest sweep showed beside the local map, frame O.
struct SweepSightings {
  struct Hit {
    geometry::Index3 voxel;
    int num_returns = 0;
  };
  base::StampNs stamp_ns = 0;
  double resolution_m = 0.0;  ///< edge of the voxels
  std::vector<Hit> hits;      ///< in voxels that the map believes to be free although the sweep hit them
  std::vector<containers::MovingThing> things;
};

/// The map by which the planner flies, in the odometry frame O: the local map as it is, the obstacles of the global map
/// through T_W_O, the altitude limits of the map frame, the fences of the flight, and the vehicle's own place.
/// Thread-safe; views are snapshots.
class NavigationMap {
 public:
  /// @throws base::ConfigError
  explicit NavigationMap(const NavigationMapConfig& config);
  ~NavigationMap();

  enum class Applied {
    kApplied,
    kNeedsSnapshot,  ///< a message was missed, or changes came before any snapshot: a snapshot has to be requested
    kIgnored         ///< the update is older than the grid
  };
  friend constexpr auto words_of(Applied) { return std::array{"applied", "needs_snapshot", "ignored"}; }
  /// @param sequence  sequence number of the message; the numbers of changes must follow each other without a gap
  /// @throws std::invalid_argument if the lengths of the update do not match, or resolution_m is not positive
  Applied apply_local(const containers::GridUpdate& update, std::uint32_t sequence, double resolution_m);
  Applied apply_obstacles(const containers::GridUpdate& update, std::uint32_t sequence, double resolution_m);

  /// Takes what the newest sweep showed beside the local map; it holds until the next sweep.
  /// @throws std::invalid_argument if a thing is not finite, or resolution_m is not positive
  void set_sightings(const SweepSightings& sightings);
  /// Sets where other UAVs will be, frame O; it counts from the next sightings on.
  /// @throws std::invalid_argument if one has no places, or a number that is not finite or out of its range
  void set_others(std::vector<containers::OtherUav> others);
  void set_T_W_O(const geometry::Pose& T_W_O);
  void set_vehicle(const geometry::Vec3& position_O);
  /// Sets the fences of the flight, null for none.
  void set_fences(std::shared_ptr<const planning::Fences> fences_O);
  /// Replaces the altitude limits of the configuration, for all later views. @throws base::ConfigError
  void set_altitudes(double min_m, double max_m);
  /// Forgets both grids; to be called after a restart of their source or a jump of the clock.
  void clear_local();
  void clear_obstacles();

  /// Returns a snapshot; null until there are a local map, a vehicle position and T_W_O.
  std::shared_ptr<const planning::OccupancyView> view() const;

 private:
  struct Layer {
    std::shared_ptr<containers::StateGrid> grid;
    std::uint32_t sequence = 0;
    int num_ignored = 0;  ///< updates ignored in a row; many mean that the source was restarted
    Applied apply(const containers::GridUpdate& update, std::uint32_t next, double resolution_m);
  };

  NavigationMapConfig config_;
  mutable std::mutex mutex_;
  Layer local_;
  Layer obstacles_;
  std::optional<geometry::Pose> T_W_O_;
  std::optional<geometry::Vec3> vehicle_O_;
  std::shared_ptr<const PlacedSightings> sightings_;
  std::shared_ptr<const std::vector<containers::OtherUav>> others_O_;
  std::shared_ptr<const planning::Fences> fences_O_;
  mutable std::shared_ptr<const planning::FenceRaster> raster_;  ///< kept while the fences are the same
  std::shared_ptr<TerrainSource> terrain_;                       ///< made from one view to the next
  mutable std::shared_ptr<const PlacedObstacles> placed_;        ///< kept from one view to the next while nothing moves
};

}  // namespace voxnav::pipeline
