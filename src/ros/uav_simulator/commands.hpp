// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrs_msgs/GetPathSrv.h>
#include <mrs_msgs/ObstacleSectors.h>
#include <mrs_msgs/PathSrv.h>
#include <mrs_msgs/ReferenceStamped.h>
#include <mrs_msgs/ReferenceStampedSrv.h>
#include <mrs_msgs/String.h>
#include <mrs_msgs/TrajectoryReferenceSrv.h>
#include <mrs_msgs/Vec1.h>
#include <mrs_msgs/Vec4.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "frames.hpp"
#include "voxnav_simulation/safety_area.hpp"
#include "voxnav_simulation/service_times.hpp"
#include "voxnav_simulation/trajectory_generator.hpp"
#include "voxnav_simulation/uav.hpp"
#include "voxnav_simulation/uav_simulator_config.hpp"

namespace voxnav_ros {

/// The MRS commands: services and topics of control_manager, uav_manager, constraint_manager and trajectory_generation,
/// with their refusals. Callbacks may come from several threads, also while simulated time stands still.
class UavCommands {
 public:
  struct Shared {
    std::mutex* mutex;  ///< guards everything below
    voxnav_simulation::Uav* uav;
    voxnav_simulation::ConstraintSet* constraints;
    voxnav_simulation::ServiceTimes* service_times;
  };
  struct Config {
    voxnav_simulation::UavConstraintsConfig constraints;
    voxnav_simulation::TrajectoryGeneratorConfig generator;
    voxnav_simulation::SafetyAreaConfig safety_area;
    voxnav_simulation::UavSimulatorConfig node;
  };
  /// @param take_off_refusal  is asked before take-off; an empty answer allows it, any other is the reason why not
  UavCommands(ros::NodeHandle& nh, const Shared& shared, UavFrames& frames, const Config& config,
              std::function<std::string()> take_off_refusal);

 private:
  using Result = voxnav_simulation::CommandResult;
  using Trigger = std_srvs::Trigger;
  using Duration = voxnav::base::StampNs (voxnav_simulation::ServiceTimes::*)();

  /// Lets the simulated time of a service pass; to be called while nothing is locked.
  void let_pass(Duration duration);
  void advertise_triggers(ros::NodeHandle& nh);
  void advertise_references(ros::NodeHandle& nh);
  void advertise_trajectories(ros::NodeHandle& nh);
  void advertise_others(ros::NodeHandle& nh);
  void advertise_emergencies(ros::NodeHandle& nh);
  void advertise_validation(ros::NodeHandle& nh);
  void serve_string(ros::NodeHandle& nh, const std::string& name,
                    const std::function<Result(const std::string&)>& command);
  void set_bool(ros::NodeHandle& nh, const std::string& name, const std::function<Result(bool)>& command);
  void trigger(ros::NodeHandle& nh, const std::string& name, const std::function<Result()>& command);

  void hear_sectors(const mrs_msgs::ObstacleSectors& msg);
  Result validate(const std_msgs::Header& header, const mrs_msgs::Reference& reference,
                  voxnav_simulation::SafetyLimits limits);
  Result set_constraints(const std::string& name);
  Result stop_tracking();
  Result start_tracking();
  Result resume_tracking();
  Result go_to_start();
  Result go_to(const std_msgs::Header& header, const mrs_msgs::Reference& reference);
  Result go_to_relative(const mrs_msgs::Vec4::Request& request);
  /// Expresses a reference in another frame, which may be latlon_origin for the one that is given.
  Result transform(const std::string& to, const mrs_msgs::ReferenceStamped& from, mrs_msgs::ReferenceStamped* out);
  Result go_to(const voxnav_simulation::HeadedPoint& goal_O);
  struct Flown {
    Result result;
    bool is_modified = false;  ///< the safety area has cut the trajectory
  };
  Flown fly(const mrs_msgs::TrajectoryReference& msg);
  Result fly(const voxnav_simulation::TrackedTrajectory& trajectory);

  struct Plan {
    voxnav_simulation::GeneratedTrajectory generated;   ///< trajectory in the control frame
    std::vector<voxnav_simulation::HeadedPoint> front;  ///< samples of the prediction that are flown before it
    bool has_dropped_waypoint = false;
    ros::Time stamp;
  };
  Plan plan(const mrs_msgs::Path& path, const voxnav::geometry::Pose& T_O_path);
  void set_start(const mrs_msgs::Path& path, voxnav_simulation::PathRequest* request, Plan* out);
  void get_path(const mrs_msgs::Path& path, mrs_msgs::GetPathSrv::Response* response);

  Shared shared_;
  UavFrames& frames_;
  Config config_;
  std::function<std::string()> take_off_refusal_;
  std::optional<voxnav_simulation::TrackedTrajectory> loaded_;  ///< the last trajectory given; guarded like uav
  double stopped_at_s_ = 0;                                     ///< time along it at which tracking was stopped
  std::vector<ros::ServiceServer> services_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace voxnav_ros
