// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "voxnav/pipeline/planning_manager_config.hpp"
#include "voxnav/planning/occupancy_view.hpp"
#include "voxnav/planning/trajectory.hpp"

namespace voxnav::pipeline {

/// A trajectory from where the vehicle is, and what has to be known to stop on it.
struct FlownTrajectory {
  const planning::Trajectory& trajectory;
  double from_arc_m;  ///< where the vehicle is
  double radius_m;    ///< that must be known free around it
  geometry::Vec3 velocity_O;
  planning::DynamicsLimits limits;  ///< must be valid
};

/// What of a trajectory may be flown.
struct SafePart {
  /// The whole trajectory if its corridor is known free; else as much as can be flown and stopped in, from where the
  /// vehicle is; nothing when there is no room to stop.
  std::optional<planning::Trajectory> trajectory;
  std::string problem;  ///< where the corridor is not known free, for a person; empty when it is
};

/// Checks the corridor of a trajectory and cuts it. @param view in the frame of the trajectory
SafePart safe_part(const PlanningManagerConfig& config, const planning::OccupancyView& view,
                   const FlownTrajectory& flown);

}  // namespace voxnav::pipeline
