// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/planning_manager.hpp"

#include <cmath>
#include <cstdio>

namespace voxnav::pipeline {
namespace {

using geometry::Vec3;
using planning::PlanStatus;

constexpr double kMaxGoalDistance_m = 1e5;
constexpr double kClockJump_s = 1.0;
constexpr double kHoverRetry_s = 1.0;
/// Diagnostics this much later than a hover show whether the tracker brakes.
constexpr double kHoverShows_s = 0.5;
/// The tracker has stopped, however fast it flew, after this time.
constexpr double kHoverLasts_s = 10.0;
/// The tracker may end a trajectory this much before its last point.
constexpr double kTrackerStep_s = 0.3;
/// The map correction may move the goal this far in O before a way to it is planned anew.
constexpr double kGoalShift_m = 0.3;
/// Moving this far is progress.
constexpr double kProgress_m = 1.0;

std::string meters(const char* format, double value) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

}  // namespace

PlanningManager::PlanningManager(const PlanningManagerConfig& config, double min_altitude_m, double max_altitude_m)
    : config_(base::checked(config)), min_altitude_m_(min_altitude_m), max_altitude_m_(max_altitude_m) {}

std::string PlanningManager::set_goal(const Vec3& goal_W, std::optional<double> heading_rad, double now_s) {
  if (!goal_W.allFinite() || (heading_rad && !std::isfinite(*heading_rad))) return "goal is not finite";
  if (goal_W.norm() > kMaxGoalDistance_m) return "goal is more than 100 km from the map's origin";
  if (goal_W.z() < min_altitude_m_) return meters("goal is below the lowest altitude of %.1f m", min_altitude_m_);
  if (goal_W.z() > max_altitude_m_) return meters("goal is above the highest altitude of %.1f m", max_altitude_m_);
  goal_ = Goal{goal_W, heading_rad};
  status_.goal_W = goal_W;
  status_.is_goal_reached = false;
  job_.reset();
  if (flight_) flight_->is_to_goal = false;
  if (flight_) flight_->left_m = 1e18;
  next_plan_s_ = now_s;
  progress_s_ = -1e18;
  was_in_control_ = false;
  enter(PlannerState::kPlanning, "new goal");
  return {};
}

Actions PlanningManager::stop(const std::string& reason, double now_s) {
  goal_.reset();
  status_.goal_W.reset();
  job_.reset();
  enter(PlannerState::kIdle, reason);
  return hover(reason, now_s);
}

Actions PlanningManager::frame_jumped(const std::string& reason, double now_s) {
  job_.reset();
  next_plan_s_ = now_s + config_.retry_interval_s;
  if (!flight_) return {};
  enter(goal_ ? PlannerState::kPlanning : PlannerState::kIdle, reason);
  return hover(reason, now_s);
}

void PlanningManager::enter(PlannerState state, const std::string& reason) {
  status_.state = state;
  status_.reason = reason;
}

Actions PlanningManager::lose(const std::string& problem, double now_s) {
  job_.reset();
  progress_s_ = -1e18;
  next_plan_s_ = now_s;
  if (flight_) {
    enter(PlannerState::kIdle, "hover: " + problem);
    return hover(problem, now_s);
  }
  const bool is_in_air = inputs_.control && inputs_.control->value.is_flying;
  if (goal_) enter(PlannerState::kIdle, (is_in_air ? "hover: " : "waiting: ") + problem);
  return {};
}

/// What somebody else has made of the vehicle while it flew for voxnav; nothing as long as it is ours. The control
/// manager takes the callbacks away during any hover: those of voxnav's own hovers come back a little later.
std::optional<std::string> PlanningManager::foreign_command(double now_s) {
  if (!inputs_.control || now_s - inputs_.control->stamp_s > config_.diagnostics_timeout_s) return std::nullopt;
  const ControlState& control = inputs_.control->value;
  const double stamp_s = inputs_.control->stamp_s;
  const bool is_free = control.is_flying && control.accepts_goals;
  const bool has_shown = own_hover_s_ && stamp_s > *own_hover_s_ + (is_free ? kHoverShows_s : kHoverLasts_s);
  if (has_shown) own_hover_s_.reset();
  const bool was_in_control = was_in_control_;
  was_in_control_ = was_in_control_ || is_free;
  if (was_in_control && !control.is_flying) return "landed or no longer flown normally";
  if (was_in_control && !control.accepts_goals && !own_hover_s_) return "somebody else let the vehicle hover or land";
  if (!flight_ || own_hover_s_ || stamp_s < flight_->begin_s) return std::nullopt;
  flight_->is_tracked = flight_->is_tracked || control.is_tracking;
  const bool is_over = stamp_s > flight_->ask_s + flight_->trajectory.duration_s() - kTrackerStep_s;
  if (flight_->is_tracked && !control.is_tracking && !is_over) return "somebody else commands the vehicle";
  return std::nullopt;
}

Actions PlanningManager::tick(double now_s) {
  const bool has_jumped = now_s < last_now_s_ - kClockJump_s;
  last_now_s_ = now_s;
  if (has_jumped) {
    inputs_ = PlanningInputs{};
    hover_sent_s_ = next_plan_s_ = -1e18;
    return lose("clock jumped back", now_s);
  }
  if (const auto taken = goal_ ? foreign_command(now_s) : std::nullopt) {
    goal_.reset();
    status_.goal_W.reset();
    job_.reset();
    flight_.reset();  // and no hover: the vehicle is somebody else's now
    hover_wanted_.reset();
    enter(PlannerState::kIdle, "goal dropped: " + *taken);
    return {};
  }
  const bool is_on_ground = inputs_.control && !inputs_.control->value.is_flying;
  if (hover_wanted_ && is_on_ground) hover_wanted_.reset();  // nobody hovers there
  if (hover_wanted_) {
    return now_s - hover_sent_s_ > kHoverRetry_s ? hover(*hover_wanted_, now_s) : Actions{};
  }
  const bool is_braking = own_hover_s_ && !flight_ && inputs_.control && !inputs_.control->value.accepts_goals;
  if (is_braking) return {};  // as voxnav wanted it, and for the reason that is shown already
  if (const auto problem = inputs_.problem(now_s, config_)) return lose(*problem, now_s);
  if (!goal_) {
    if (flight_ && !is_flying_trajectory(now_s)) flight_.reset();
    return {};
  }
  if (finish_if_reached(now_s)) return {};
  if (job_ && now_s - job_->begin_s > config_.job_timeout_s) {
    const char* what = job_->stage == ActionKind::kPlan       ? "search"
                       : job_->stage == ActionKind::kGenerate ? "trajectory generator"
                                                              : "trajectory service";
    job_.reset();
    plan_failed(std::string(what) + " does not answer", now_s);
  }
  note_progress(now_s);
  if (now_s - progress_s_ > config_.stuck_time_s) return give_up("stuck: " + status_.reason, now_s);
  if (status_.state == PlannerState::kIdle) enter(PlannerState::kPlanning, "flight resumes");
  return is_replan_due(now_s) ? start_plan(now_s) : Actions{};
}

bool PlanningManager::finish_if_reached(double now_s) {
  const double distance_m = (inputs_.vehicle->value.position_O - goal_O()).norm();
  const bool is_rest = speed() < config_.rest_speed_mps && !is_flying_trajectory(now_s);
  if (distance_m > config_.goal_tolerance_m || !is_rest) return false;
  goal_.reset();
  status_.goal_W.reset();
  status_.is_goal_reached = true;
  job_.reset();
  flight_.reset();
  enter(PlannerState::kIdle, meters("goal reached, %.2f m from it", distance_m));
  return true;
}

Actions PlanningManager::give_up(const std::string& reason, double now_s) {
  goal_.reset();
  status_.goal_W.reset();
  job_.reset();
  enter(PlannerState::kIdle, reason);
  return hover(reason, now_s);
}

void PlanningManager::note_progress(double now_s) {
  const Vec3& position = inputs_.vehicle->value.position_O;
  if (progress_s_ > -1e17 && (position - progress_O_).norm() < kProgress_m) return;
  progress_O_ = position;
  progress_s_ = now_s;
}

bool PlanningManager::is_replan_due(double now_s) const {
  if (job_ || now_s < next_plan_s_) return false;
  if (!is_flying_trajectory(now_s)) return true;
  const bool goal_has_moved = (flight_->goal_O - goal_O()).norm() > kGoalShift_m;
  return !flight_->is_to_goal || goal_has_moved;
}

geometry::Vec3 PlanningManager::goal_O() const { return inputs_.T_W_O->value.inverse() * goal_->position_W; }

Actions PlanningManager::start_plan(double now_s) {
  Action action;
  action.kind = ActionKind::kPlan;
  action.job = ++last_job_;
  action.goal_O = goal_O();
  action.start_O = inputs_.vehicle->value.position_O;
  if (speed() > config_.rest_speed_mps || is_flying_trajectory(now_s)) {
    const double stamp_s = now_s + config_.planning_budget_s + config_.generation_budget_s;
    const auto predicted = inputs_.prediction->value.at(stamp_s);
    if (!predicted) {
      plan_failed("tracker prediction is too short", now_s);
      return {};
    }
    action.start_O = *predicted;
    action.start_stamp_s = stamp_s;
  }
  job_ = Job{action.job, ActionKind::kPlan, now_s, action.start_stamp_s, false, {}, {}};
  ++status_.num_plans;
  if (!is_flying_trajectory(now_s)) status_.state = PlannerState::kPlanning;
  return {action};
}

void PlanningManager::plan_failed(const std::string& problem, double now_s) {
  next_plan_s_ = now_s + config_.retry_interval_s;
  const bool is_moving = is_flying_trajectory(now_s);
  enter(is_moving ? PlannerState::kMoving : PlannerState::kPlanning, problem);
}

/// A new trajectory replaces one that is still good only if it leads clearly nearer to the goal: this keeps the
/// vehicle from dithering between ways of like length.
bool PlanningManager::is_worth_flying(const PlanOutcome& outcome, double now_s) const {
  if (!is_flying_trajectory(now_s)) return true;
  if ((flight_->goal_O - goal_O()).norm() > kGoalShift_m || outcome.is_to_goal) return true;
  return outcome.left_m < flight_->left_m - config_.min_progress_m;
}

Actions PlanningManager::plan_done(std::uint64_t job, const PlanOutcome& outcome, double now_s) {
  if (!job_ || job_->id != job || job_->stage != ActionKind::kPlan) return {};
  status_.plan_status = to_string(outcome.plan.status);
  status_.expansions = outcome.plan.expansions;
  status_.plan_s = outcome.plan.seconds;
  const auto start_stamp_s = job_->start_stamp_s;
  job_.reset();
  if (outcome.waypoints_O.empty()) {
    // Near a goal that cannot be entered there is nothing left to wait for.
    const bool is_final = outcome.plan.status == PlanStatus::kGoalBlocked && !is_flying_trajectory(now_s) &&
                          !outcome.plan.path.empty() && planning::length_of(outcome.plan.path) < config_.min_progress_m;
    if (is_final) return give_up("goal cannot be reached: " + outcome.problem, now_s);
    plan_failed(outcome.problem, now_s);
    return {};
  }
  if (!is_worth_flying(outcome, now_s)) {
    next_plan_s_ = now_s + config_.replan_interval_s;
    return {};
  }
  Action action;
  action.kind = ActionKind::kGenerate;
  action.job = ++last_job_;
  action.waypoints_O = outcome.waypoints_O;
  action.start_O = outcome.waypoints_O.front();
  action.goal_O = outcome.waypoints_O.back();
  action.start_stamp_s = start_stamp_s;
  if (outcome.is_to_goal && goal_->heading_rad) {
    action.heading_rad = geometry::wrap_angle(*goal_->heading_rad - geometry::yaw_of(inputs_.T_W_O->value));
  }
  job_ = Job{action.job, ActionKind::kGenerate, now_s, start_stamp_s, false, outcome, {}};
  return {action};
}

}  // namespace voxnav::pipeline
