// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "voxnav_simulation/sensed_world.hpp"
#include "voxnav_simulation/tracker.hpp"
#include "voxnav_simulation/uav_setup.hpp"

namespace voxnav_simulation {

/// A multirotor as mapping and planning see it: it follows references within limits, tilts as its accelerations
/// require, and controls by an estimate that drifts away from the truth. Commands and predictions are in the frame O of
/// the estimate; the true position is that of the body in O minus the drift. Without faults the body is where the
/// tracker's state is, and the estimate shows it exactly. One step is kStep_s. Deterministic for a seed. Not
/// thread-safe.
class Uav {
 public:
  /// @throws voxnav::base::ConfigError
  Uav(const UavSetup& setup, std::uint64_t seed, SensedWorld sensed_world = {});

  void step();
  voxnav::base::StampNs stamp_ns() const { return stamp_ns_; }
  /// Sets the stamp of an idle vehicle, from which its steps count on.
  void set_stamp_ns(voxnav::base::StampNs stamp_ns) { stamp_ns_ = stamp_ns; }

  /// Commands. The result of a refused command holds the reason.
  CommandResult take_off();
  CommandResult land();
  CommandResult hover();
  /// Emergencies (mrs_uav_managers/src/control_manager/control_manager.cpp: ehover, eland, failsafe). They take the
  /// callbacks away. An emergency hover lasts until somebody switches tracker and controller and enables the callbacks;
  /// the other two end on the ground. The simulated failsafe brakes like a landing, a real one does not.
  CommandResult ehover();
  CommandResult eland();
  CommandResult failsafe();
  /// Activates the tracker or the controller of normal flight again, after an emergency hover.
  CommandResult switch_to_normal_tracker();
  CommandResult switch_to_normal_controller();
  CommandResult go_to(const HeadedPoint& goal_O);
  CommandResult set_trajectory(const TrackedTrajectory& trajectory_O);
  void set_limits(const TrackerLimits& limits) { tracker_.set_limits(limits); }
  /// Lets the control manager take commands, or refuse all of them.
  void enable_callbacks(bool is_enabled) { has_callbacks_ = is_enabled; }
  /// Lets a pilot take the vehicle by remote control, and first hold it where it is, or give it back.
  CommandResult set_remote(bool is_remote);
  /// Takes what a message of obstacle sectors tells, for a bumper that heeds them.
  void set_sectors(const SectorRanges& sectors) { sectors_ = {sectors, stamp_ns_}; }

  FlightPhase phase() const { return phase_; }
  const BodyState& truth() const { return truth_; }        ///< in W
  const BodyState& estimate() const { return estimate_; }  ///< in O
  const ImuReading& imu() const { return imu_; }           ///< the measurement of the last step
  /// The position in O minus that in W, which includes jumps of the estimator.
  Vec3 drift() const { return drift_.position() + jump_; }
  /// How often the estimator was reset, so that O jumped.
  std::uint32_t estimator_iteration() const { return estimator_iteration_; }
  /// Whether an obstacle repels the vehicle, so that callbacks are disabled.
  bool is_repelled() const { return is_repelled_; }
  bool is_remote() const { return is_remote_; }
  /// Whether the vehicle flies to what it is told: in the air, and nobody else has it.
  bool is_flying_normally() const {
    return phase_ == FlightPhase::kFlying && has_callbacks_ && !is_remote_ && !is_repelled_ && !is_in_emergency();
  }
  /// Whether the tracker of take-off and landing holds the vehicle in the air after an emergency hover.
  bool is_held() const { return is_held_; }
  ActiveController controller() const { return controller_; }
  /// Whether the vehicle flies over another one.
  bool is_avoiding() const { return climb_.floor_m().has_value(); }
  /// Returns the height of the body above the ground, or nothing outside of the world.
  std::optional<double> height_m() const;
  /// Returns the range to the ground along the body's z axis, or nothing if the ground is out of range.
  std::optional<double> rangefinder();

  const Tracker& tracker() const { return tracker_; }
  /// Returns the state in O at `ahead_s` from now, rounded to steps and limited to 10 s.
  const KinematicState& predicted(double ahead_s);

 private:
  std::string refusal() const;
  std::string reference_refusal() const;
  bool is_in_emergency() const { return is_held_ || controller_ != ActiveController::kNormal; }
  std::string emergency_refusal(const char* what) const;
  void begin_landing(const Vec3& goal);
  std::optional<Vec3> landing_place() const;
  std::optional<Vec3> push() const;
  void place(double dt_s);
  void stand();
  void meet_faults();
  bool has_room_above() const;
  void meet_obstacles();
  void update_phase();
  void measure(const BodyState& before);

  UavConfig config_;
  AvoidanceConfig avoidance_;
  SensedWorld sensed_world_;
  GnssDrift drift_;
  ImuModel imu_model_;
  Rng random_;
  Tracker tracker_;
  TrackingResponse response_;
  Wind wind_;
  StateNoise noise_;
  AvoidanceClimb climb_;
  Bumper bumper_;
  EstimatorResets resets_;
  Vec3 jump_ = Vec3::Zero();
  voxnav::base::StampNs stamp_ns_ = 0;
  Vec3 standing_W_ = Vec3::Zero();
  double standing_heading_rad_ = 0;  ///< true heading
  BodyState truth_;
  BodyState estimate_;
  ImuReading imu_;
  std::uint32_t estimator_iteration_ = 0;
  FlightPhase phase_ = FlightPhase::kIdle;
  RefusalsConfig refusals_;
  bool is_free_;  ///< whether the body moves by its own response and not exactly as the tracker
  bool is_repelled_ = false;
  bool has_callbacks_ = true;
  bool is_remote_ = false;
  bool is_held_ = false;
  ActiveController controller_ = ActiveController::kNormal;
  struct HeardSectors {
    SectorRanges ranges;
    voxnav::base::StampNs stamp_ns = 0;
  };
  std::optional<HeardSectors> sectors_;
};

/// Returns the orientation of a multirotor whose thrust gives this acceleration. Seen from above, the body's x axis
/// points along the heading.
Eigen::Matrix3d attitude_of(const Vec3& acceleration, double heading_rad);

}  // namespace voxnav_simulation
