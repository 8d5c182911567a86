// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav_simulation {

/// Parameters of the uav_simulator node besides those of the vehicle.
struct UavSimulatorConfig {
  std::string world_yaml;
  int seed = 1;
  int seed_offset = 0;
  std::string uav_name = "uav1";
  std::string estimator = "gps_garmin";
  double origin_latitude_deg = 49.3625;
  double origin_longitude_deg = 14.2613;
  double utm_east_m = 446363.0;
  double utm_north_m = 5468016.8;
  double vehicle_radius_m = 0.35;
  double clearance_max_m = 20.0;
  int clock_hz = 100;
  int state_hz = 100;
  int tracker_cmd_hz = 20;
  double speed_factor = 1.0;
  double start_time_s = 10.0;
  bool follows_clock = false;
  std::vector<std::string> lockstep_nodes{};
  std::string lockstep_leader;
  double lockstep_lag_s = 0.3;
  double lockstep_period_s = 0.0;
  double lockstep_timeout_s = 20.0;

  template <class V>
  static void fields(V&& v) {
    using C = UavSimulatorConfig;
    using voxnav::base::any;
    using voxnav::base::in;
    v("world_yaml", &C::world_yaml, any(), "",
      "file of the world, as worlds/forest.yaml; empty: flat ground at height 0");
    v("seed", &C::seed, in(0, 2147483647), "", "seed of the world, the drift and the sensors' errors");
    v("seed_offset", &C::seed_offset, in(0, 1000000), "",
      "added to the seed for all but the world, so that two vehicles in one world differ");
    v("uav_name", &C::uav_name, any(), "", "prefix of all frames");
    v("estimator", &C::estimator, any(), "",
      "name of the active estimator; its frame is <uav_name>/<estimator>_origin");
    v("origin_latitude_deg", &C::origin_latitude_deg, in(-89, 89), "deg", "latitude of the world's origin");
    v("origin_longitude_deg", &C::origin_longitude_deg, in(-180, 180), "deg", "longitude of the world's origin");
    v("utm_east_m", &C::utm_east_m, in(-1e6, 1e6), "m", "easting of the world's origin in UTM, as its place above has");
    v("utm_north_m", &C::utm_north_m, in(-1e7, 1e7), "m", "its northing in UTM");
    v("vehicle_radius_m", &C::vehicle_radius_m, in(0.05, 5), "m", "closer to a surface than this is a collision");
    v("clearance_max_m", &C::clearance_max_m, in(1, 1000), "m", "surfaces farther away are not looked for");
    v("clock_hz", &C::clock_hz, in(20, 200), "Hz", "simulated rate of /clock; divides 200");
    v("state_hz", &C::state_hz, in(10, 200), "Hz",
      "rate of uav_state, odom_main, tf and ground truth; divides clock_hz");
    v("tracker_cmd_hz", &C::tracker_cmd_hz, in(1, 200), "Hz", "rate of tracker_cmd; divides clock_hz");
    v("speed_factor", &C::speed_factor, in(0, 100), "", "simulated seconds per second; 0: as fast as lock-step allows");
    v("start_time_s", &C::start_time_s, in(1, 2e9), "s", "simulated time at the start");
    v("follows_clock", &C::follows_clock, any(), "",
      "the simulator of another UAV owns /clock, and waits for this one under uav_name");
    v("lockstep_nodes", &C::lockstep_nodes, any(), "",
      "nodes whose progress simulated time waits for; none: real time");
    v("lockstep_leader", &C::lockstep_leader, any(), "",
      "node whose progress says how far time may run; before its first report it stands still; empty: none");
    v("lockstep_lag_s", &C::lockstep_lag_s, in(0.01, 60), "s", "how far behind these nodes may be");
    v("lockstep_period_s", &C::lockstep_period_s, in(0, 10), "s",
      "time stands still for them at multiples of this only: the LiDAR's period; 0: at any time");
    v("lockstep_timeout_s", &C::lockstep_timeout_s, in(0.1, 3600), "s",
      "wall time after which a silent node is left behind");
  }
  std::vector<std::string> problems() const;
};

}  // namespace voxnav_simulation
