// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrs_msgs/ConstraintManagerDiagnostics.h>
#include <mrs_msgs/ControlManagerDiagnostics.h>
#include <mrs_msgs/EstimationDiagnostics.h>
#include <mrs_msgs/FutureTrajectory.h>
#include <mrs_msgs/RtkGps.h>
#include <mrs_msgs/TrackerCommand.h>
#include <mrs_msgs/UavManagerDiagnostics.h>
#include <mrs_msgs/UavState.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/Range.h>

#include <string>

#include "frames.hpp"
#include "voxnav_simulation/uav.hpp"
#include "voxnav_simulation/uav_simulator_config.hpp"

namespace voxnav_ros::uav_messages {

using voxnav_simulation::BodyState;
using voxnav_simulation::ConstraintSet;
using voxnav_simulation::TrackerLimits;
using voxnav_simulation::Uav;
using voxnav_simulation::UavSimulatorConfig;

constexpr int kNumPredicted = 40;
/// Returns how many seconds ahead the i-th sample of the tracker's prediction lies.
inline double predicted_ahead_s(int i) { return 0.01 + 0.2 * i; }

/// The odometry, with its twist in the body frame as nav_msgs asks for.
nav_msgs::Odometry odometry(const BodyState& state, const std_msgs::Header& header, const std::string& child);
/// The state, with velocity and acceleration in the header's frame as the MRS system has them. This and what follows is
/// expressed in the control frame, which is that of the header.
mrs_msgs::UavState uav_state(const Uav& uav, const std_msgs::Header& header, const UavFrames& frames);
/// The tracker's command with its prediction of 40 samples, which holds until the next command.
mrs_msgs::TrackerCommand tracker_command(Uav* uav, const std_msgs::Header& header, const UavFrames& frames);
/// What the tracker tells other UAVs: its prediction, in UTM.
mrs_msgs::FutureTrajectory future_trajectory(Uav* uav, const ros::Time& stamp, const UavSimulatorConfig& config);
mrs_msgs::DynamicsConstraints constraints(const TrackerLimits& limits);

mrs_msgs::ControlManagerDiagnostics control_diagnostics(const Uav& uav, const std_msgs::Header& header,
                                                        const std::string& uav_name, const UavFrames& frames);
mrs_msgs::ConstraintManagerDiagnostics constraint_diagnostics(const TrackerLimits& limits, ConstraintSet set,
                                                              const ros::Time& stamp);
mrs_msgs::EstimationDiagnostics estimation_diagnostics(const Uav& uav, const std_msgs::Header& header,
                                                       const UavFrames& frames, const UavSimulatorConfig& config);
mrs_msgs::UavManagerDiagnostics manager_diagnostics(const Uav& uav, const ros::Time& stamp, double flight_time_s,
                                                    const UavSimulatorConfig& config);

sensor_msgs::Imu imu(const voxnav_simulation::ImuReading& sample, const std::string& frame_id);
/// Latitude and longitude of a place in the world, which is taken as the plane that touches the earth in its origin.
sensor_msgs::NavSatFix gnss(const voxnav_simulation::Vec3& position, const std_msgs::Header& header,
                            const UavSimulatorConfig& config);
/// The place in the world of a latitude and longitude, at height 0.
voxnav_simulation::Vec3 place_of(double latitude_deg, double longitude_deg, const UavSimulatorConfig& config);
mrs_msgs::RtkGps rtk(const voxnav_simulation::Vec3& position, const std_msgs::Header& header,
                     const UavSimulatorConfig& config);
sensor_msgs::Range range(const std::optional<double>& range_m, const std_msgs::Header& header, double max_m);

}  // namespace voxnav_ros::uav_messages
