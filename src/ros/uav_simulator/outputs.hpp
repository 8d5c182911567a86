// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include <memory>
#include <string>
#include <vector>

#include "frames.hpp"
#include "voxnav_simulation/losses.hpp"
#include "voxnav_simulation/scene.hpp"
#include "voxnav_simulation/uav.hpp"
#include "voxnav_simulation/uav_simulator_config.hpp"

namespace voxnav_ros {

/// Everything that the simulated vehicle publishes, each topic at its own rate of simulated time. For one thread.
class UavOutputs {
 public:
  struct Config {
    voxnav_simulation::UavSimulatorConfig node;
    voxnav_simulation::LossesConfig losses;
  };
  UavOutputs(ros::NodeHandle& nh, ros::NodeHandle& private_nh, const Config& config, const UavFrames& frames,
             std::shared_ptr<const voxnav_simulation::Scene> scene);

  /// Collects what is due at this time. To be called while the vehicle is locked.
  void collect(voxnav_simulation::Uav* uav, voxnav_simulation::ConstraintSet constraints);
  void add_imu(const voxnav_simulation::ImuReading& sample);
  /// Sends /clock and then what was collected. To be called while the vehicle is not locked.
  void publish();
  void publish_clock(voxnav::base::StampNs stamp_ns);

 private:
  struct Batch;
  bool is_due(double hz) const;
  void collect_state(const voxnav_simulation::Uav& uav);
  void collect_sensors(voxnav_simulation::Uav* uav);
  void collect_diagnostics(const voxnav_simulation::Uav& uav, voxnav_simulation::ConstraintSet constraints);
  void watch_clearance(const voxnav_simulation::Uav& uav);
  void note_phase(const voxnav_simulation::Uav& uav);
  std_msgs::Header header(const std::string& frame_id) const;
  template <class M>
  void later(const ros::Publisher& publisher, const M& message);
  /// Messages that may be lost, and where: each kind is lost for itself.
  enum class Kind { kUavState, kOdometry, kTf, kTrackerCommand, kControl, kConstraints, kEstimation };
  bool is_lost(Kind kind) const;
  template <class M>
  void later_unless_lost(Kind kind, const ros::Publisher& publisher, const M& message) {
    if (!is_lost(kind)) later(publisher, message);
  }

  voxnav_simulation::UavSimulatorConfig config_;
  voxnav_simulation::LossesConfig losses_;
  const UavFrames& frames_;
  std::shared_ptr<const voxnav_simulation::Scene> scene_;
  voxnav::base::StampNs stamp_ns_ = 0;
  std::int64_t step_ = 0;  ///< steps of the vehicle since the start
  std::vector<std::function<void()>> queue_;
  bool was_idle_ = true;
  double take_off_s_ = 0, flight_s_ = 0;
  double min_clearance_m_ = 0;
  bool has_collided_ = false;

  tf2_ros::TransformBroadcaster tf_;
  ros::Publisher clock_, uav_state_, odom_main_, ground_truth_, imu_, rtk_, gnss_, range_, tracker_cmd_, future_,
      constraints_, control_diagnostics_, constraint_diagnostics_, estimation_diagnostics_, manager_diagnostics_,
      clearance_;
};

}  // namespace voxnav_ros
