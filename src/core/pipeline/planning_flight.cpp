// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>

#include "voxnav/pipeline/planning_manager.hpp"
#include "voxnav/planning/corridor.hpp"

namespace voxnav::pipeline {
namespace {

using geometry::Vec3;
using planning::Trajectory;

/// The vehicle is looked for this long before and after the time at which the trajectory has it.
constexpr double kBehind_s = 1.5;
constexpr double kAhead_s = 0.5;
/// Tracking lags: the vehicle comes to rest this much after the trajectory does.
constexpr double kSettling_s = 0.5;

std::string place_text(const char* what, double distance_m, const planning::CorridorResult& corridor) {
  char buffer[160];
  const Vec3& p = corridor.unsafe_point;
  const char* state = corridor.unsafe_state == containers::State::kOccupied ? "occupied" : "unknown";
  std::snprintf(buffer, sizeof buffer, "%s: %s in %.1f m at (%.1f, %.1f, %.1f)", what, state, distance_m, p.x(), p.y(),
                p.z());
  return buffer;
}

}  // namespace

bool PlanningManager::is_flying_trajectory(double now_s) const {
  return flight_ && now_s < flight_->begin_s + flight_->trajectory.duration_s() + kSettling_s;
}

double PlanningManager::arc_now(double now_s) const {
  const double t = now_s - flight_->begin_s;
  return flight_->trajectory.project(inputs_.vehicle->value.position_O, t - kBehind_s, t + kAhead_s);
}

std::vector<Vec3> PlanningManager::remaining_path(double now_s) const {
  if (!is_flying_trajectory(now_s) || !inputs_.vehicle) return {};
  return flight_->trajectory.points_from_arc(arc_now(now_s));
}

/// The whole trajectory if its corridor is known free; else as much as can be flown and stopped in; else nothing.
std::optional<Trajectory> PlanningManager::safe_part(const Trajectory& trajectory, double from_arc_m, double radius_m,
                                                     const View* view, std::string* problem) const {
  if (view == nullptr) {
    *problem = "no map to check against";
    return std::nullopt;
  }
  const auto corridor = check_corridor(*view, trajectory.points_from_arc(from_arc_m), radius_m);
  if (corridor.is_safe) return trajectory;
  *problem = place_text("not known free", corridor.first_unsafe_m, corridor);
  const double room_m = corridor.first_unsafe_m - config_.stop_margin_m;
  const double deceleration = config_.deceleration_ratio *
                              planning::braking_deceleration(trajectory, from_arc_m, from_arc_m + room_m,
                                                             inputs_.vehicle->value.velocity_O, inputs_.limits->value);
  if (room_m < planning::stopping_distance(speed(), deceleration, config_.reaction_time_s)) return std::nullopt;
  return trajectory.stopped_at(from_arc_m, from_arc_m + room_m, deceleration);
}

Actions PlanningManager::check(const View* view, double now_s) {
  // While the control manager is being told to stop, or a shortened trajectory is on its way, nothing else helps.
  if (!flight_ || hover_wanted_ || !inputs_.vehicle || !inputs_.limits) return {};
  if (!is_flying_trajectory(now_s)) return {};
  if (job_ && job_->is_shortening && now_s - job_->begin_s < config_.reaction_time_s) return {};
  const double arc_m = arc_now(now_s);
  std::string problem;
  auto part = safe_part(flight_->trajectory, arc_m, flight_->radius_m, view, &problem);
  if (problem.empty()) return {};
  const bool has_failed = job_ && job_->is_shortening;  // it was not published in time
  job_.reset();
  next_plan_s_ = now_s;
  if (!part || has_failed) {
    enter(goal_ ? PlannerState::kPlanning : PlannerState::kIdle, "brake: " + problem);
    return hover("brake: " + problem, now_s);
  }
  ++status_.num_shortened;
  enter(PlannerState::kPlanning, "shortened: " + problem);
  Actions actions = publish(std::move(*part), "shortened: " + problem, now_s);
  job_->is_shortening = true;
  job_->outcome.corridor_radius_m = flight_->radius_m;
  job_->outcome.left_m = 1e18;
  return actions;
}

Actions PlanningManager::generate_done(std::uint64_t job, const std::string& problem, const Trajectory& trajectory,
                                       const View* view, double now_s) {
  if (!job_ || job_->id != job || job_->stage != ActionKind::kGenerate) return {};
  const PlanOutcome outcome = job_->outcome;
  job_.reset();
  if (!problem.empty() || trajectory.empty()) {
    plan_failed("trajectory generator: " + (problem.empty() ? std::string("empty trajectory") : problem), now_s);
    return {};
  }
  std::string unsafe;
  auto part = safe_part(trajectory, 0.0, outcome.corridor_radius_m, view, &unsafe);
  const bool is_cut = !unsafe.empty();
  if (!part || (is_cut && part->length_m() < config_.min_progress_m)) {
    plan_failed("generated trajectory is " + unsafe, now_s);
    return {};
  }
  const double lost_m = is_cut ? trajectory.length_m() - part->length_m() : 0.0;
  Actions actions = publish(std::move(*part), outcome.is_to_goal ? "to the goal" : "towards the goal", now_s);
  job_->outcome = outcome;
  job_->outcome.is_to_goal = outcome.is_to_goal && !is_cut;
  job_->outcome.left_m += lost_m;
  return actions;
}

Actions PlanningManager::publish(Trajectory trajectory, const std::string& reason, double now_s) {
  Action action;
  action.kind = ActionKind::kPublish;
  action.job = ++last_job_;
  action.reason = reason;
  action.trajectory = trajectory;
  job_ = Job{action.job, ActionKind::kPublish, now_s, std::nullopt, false, {}, std::move(trajectory)};
  return {action};
}

Actions PlanningManager::publish_done(std::uint64_t job, const std::string& problem, double now_s) {
  if (!job_ || job_->id != job || job_->stage != ActionKind::kPublish) return {};
  Job done = std::move(*job_);
  job_.reset();
  if (!problem.empty()) {
    if (done.is_shortening) return hover("brake: shortened trajectory refused: " + problem, now_s);
    plan_failed("trajectory refused: " + problem, now_s);
    return {};
  }
  ++status_.num_trajectories;
  flight_ = Flight{std::move(done.trajectory),
                   now_s,
                   done.outcome.corridor_radius_m,
                   done.outcome.is_to_goal,
                   done.outcome.left_m,
                   goal_ ? goal_O() : Vec3::Zero(),
                   done.begin_s};
  next_plan_s_ = now_s + (done.is_shortening ? 0.0 : config_.replan_interval_s);
  if (done.is_shortening) return {};
  const bool is_whole = done.outcome.plan.status == planning::PlanStatus::kComplete;
  const std::string doubt = is_whole ? "" : std::string(": ") + explain(done.outcome.plan.status);
  enter(PlannerState::kMoving, (flight_->is_to_goal ? "moving to the goal" : "moving towards the goal") + doubt);
  return {};
}

Actions PlanningManager::hover(const std::string& reason, double now_s) {
  if (!hover_wanted_) ++status_.num_hovers;
  hover_wanted_ = reason;
  hover_sent_s_ = now_s;
  own_hover_s_ = now_s;
  flight_.reset();
  Action action;
  action.kind = ActionKind::kHover;
  action.reason = reason;
  return {action};
}

void PlanningManager::hover_done(const std::string& problem, double now_s) {
  if (problem.empty()) {
    if (own_hover_s_) own_hover_s_ = now_s;
    hover_wanted_.reset();
    next_plan_s_ = std::max(next_plan_s_, now_s);
    return;
  }
  hover_sent_s_ = now_s;  // tick() tries again
  if (hover_wanted_) status_.reason = *hover_wanted_ + "; hover fails: " + problem;
}

}  // namespace voxnav::pipeline
