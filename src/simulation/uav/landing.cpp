// SPDX-License-Identifier: BSD-3-Clause
// How a flight ends: by landing, or by an emergency.
#include "voxnav_simulation/uav.hpp"

namespace voxnav_simulation {
namespace {

/// Share of the acceleration limit with which the tracker brakes before a goal.
constexpr double kBrakeShare = 0.7;

CommandResult refused(const std::string& why) { return {false, why}; }

}  // namespace

/// Returns where the vehicle will stand, frame O; nothing outside of the world. The horizontal place is where braking
/// ends, so that the tracker, which brakes before its goal, does not turn back.
std::optional<Vec3> Uav::landing_place() const {
  const KinematicState s = tracker_.state();
  const Vec3 horizontal(s.velocity.x(), s.velocity.y(), 0);
  const double a = tracker_.limits().horizontal.acceleration;
  Vec3 goal = s.position + horizontal * (0.5 * horizontal.norm() / (kBrakeShare * a) + 0.2);
  const Vec3 goal_W = goal - drift();
  const auto ground = sensed_world_.ground_height(goal_W.x(), goal_W.y());
  if (!ground) return std::nullopt;
  goal.z() = *ground + config_.standing_height_m + drift().z();
  return goal;
}

void Uav::begin_landing(const Vec3& goal) {
  phase_ = FlightPhase::kLanding;
  tracker_.go_to({goal, tracker_.state().heading_rad});
}

CommandResult Uav::land() {
  if (phase_ == FlightPhase::kIdle) return refused("not flying");
  if (phase_ == FlightPhase::kLanding) return refused("already landing");
  const auto place = landing_place();
  if (!place) return refused("no ground below");
  begin_landing(*place);
  return {true, "landing"};
}

/// Why an emergency is not begun; empty if it is.
std::string Uav::emergency_refusal(const char* what) const {
  if (phase_ == FlightPhase::kIdle) return std::string("can not trigger ") + what + " while not flying";
  if (controller_ == ActiveController::kFailsafe) return std::string("cannot ") + what + ", failsafe already triggered";
  return {};
}

CommandResult Uav::ehover() {
  if (phase_ == FlightPhase::kLanding && is_in_emergency()) {
    return refused("can not switch controller, eland or failsafe active");
  }
  if (const std::string why = emergency_refusal("ehover"); !why.empty()) return refused(why);
  phase_ = FlightPhase::kFlying;
  controller_ = ActiveController::kEmergency;
  is_held_ = true;
  has_callbacks_ = is_repelled_ = false;
  tracker_.brake();
  return {true, "ehover activated"};
}

CommandResult Uav::eland() {
  if (const std::string why = emergency_refusal("eland"); !why.empty()) return refused(why);
  if (phase_ == FlightPhase::kLanding && controller_ == ActiveController::kEmergency) {
    return refused("cannot eland, eland already triggered");
  }
  const auto place = landing_place();
  if (!place) return refused("error during activation of eland");
  controller_ = ActiveController::kEmergency;
  is_held_ = true;
  has_callbacks_ = false;
  begin_landing(*place);
  return {true, "eland activated"};
}

CommandResult Uav::failsafe() {
  if (const std::string why = emergency_refusal("failsafe"); !why.empty()) return refused(why);
  const auto place = landing_place();
  if (!place) return refused("no ground below");
  controller_ = ActiveController::kFailsafe;
  has_callbacks_ = false;
  begin_landing(*place);
  return {true, "failsafe activated"};
}

CommandResult Uav::switch_to_normal_tracker() {
  if (phase_ != FlightPhase::kFlying) return refused("can not switch the tracker, not flying");
  is_held_ = false;
  return {true, "tracker switched"};
}

CommandResult Uav::switch_to_normal_controller() {
  if (phase_ != FlightPhase::kFlying) return refused("can not switch the controller, not flying");
  controller_ = ActiveController::kNormal;
  return {true, "controller switched"};
}

}  // namespace voxnav_simulation
