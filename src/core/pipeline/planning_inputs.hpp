// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/planning_manager_config.hpp"
#include "voxnav/planning/flight_time.hpp"

namespace voxnav::pipeline {

/// A value with the time at which it was true [s].
template <class T>
struct Timed {
  double stamp_s = 0.0;
  T value{};
};

struct VehicleState {
  geometry::Vec3 position_O = geometry::Vec3::Zero();
  geometry::Vec3 velocity_O = geometry::Vec3::Zero();
};

/// Where the tracker will be, as MPC has it.
struct Prediction {
  std::vector<double> times_s;
  std::vector<geometry::Vec3> positions_O;
  /// Nothing outside the predicted time.
  std::optional<geometry::Vec3> at(double time_s) const;
};

struct ControlState {
  bool is_flying = false;      ///< control manager: flying normally
  bool accepts_goals = false;  ///< tracker callbacks enabled; MRS takes them away while it brakes to hover
  bool is_tracking = false;    ///< the tracker follows a trajectory
};

/// Newest of everything the planning manager is told about the vehicle and the maps.
struct PlanningInputs {
  std::optional<Timed<VehicleState>> vehicle;
  std::optional<Timed<Prediction>> prediction;
  std::optional<Timed<ControlState>> control;
  std::optional<Timed<planning::DynamicsLimits>> limits;
  std::optional<Timed<geometry::Pose>> T_W_O;
  std::optional<double> map_stamp_s;
  std::string map_frame;             ///< of the local map; empty until it is known
  std::string control_frame;         ///< of the odometry; empty until it is known
  std::set<std::string> lost_nodes;  ///< nodes whose heartbeat is missing

  /// Why nobody may fly now; nothing when all is well.
  std::optional<std::string> problem(double now_s, const PlanningManagerConfig& config) const;
};

}  // namespace voxnav::pipeline
