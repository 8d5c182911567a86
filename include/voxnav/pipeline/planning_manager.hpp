// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "pipeline/plan_job.hpp"
#include "pipeline/planning_action.hpp"
#include "pipeline/planning_inputs.hpp"

namespace voxnav::pipeline {

/// The states Idle, Planning and Moving, free of ROS, threads and clocks: it is told the time and what has happened,
/// and answers with what is to be done. Searching and services run elsewhere; their answers come back by the *_done
/// calls, and answers to jobs that no longer matter are ignored.
///
/// The vehicle always holds a trajectory that ends at rest in known free space; when that is no longer so, the
/// trajectory is shortened, or the vehicle brakes. Whatever is lost (odometry, map, correction, services) leads to
/// hover with a reason; the goal is kept and the flight resumes. Not thread-safe.
/// Source: thesis, section 5.4 (planning manager).
class PlanningManager {
 public:
  using View = planning::OccupancyView;

  /// @param min_altitude_m, max_altitude_m goals outside are refused, frame W
  /// @throws base::ConfigError
  PlanningManager(const PlanningManagerConfig& config, double min_altitude_m, double max_altitude_m);

  /// What is known of vehicle and maps; to be kept up to date by the owner.
  PlanningInputs& inputs() { return inputs_; }

  /// @param heading_rad at the goal, frame W
  /// @return why the goal is refused; empty when it is taken
  std::string set_goal(const geometry::Vec3& goal_W, std::optional<double> heading_rad, double now_s);
  /// Drops the goal and hovers.
  Actions stop(const std::string& reason, double now_s);
  /// The odometry frame has jumped: nothing that was planned holds.
  Actions frame_jumped(const std::string& reason, double now_s);

  /// Main loop, 20 Hz.
  Actions tick(double now_s);
  /// Corridor check, 10 Hz. A null view counts as unsafe.
  Actions check(const View* view, double now_s);

  Actions plan_done(std::uint64_t job, const PlanOutcome& outcome, double now_s);
  /// @param problem empty on success; @param view verifies the trajectory itself, null counts as unsafe
  Actions generate_done(std::uint64_t job, const std::string& problem, const planning::Trajectory& trajectory,
                        const View* view, double now_s);
  Actions publish_done(std::uint64_t job, const std::string& problem, double now_s);
  void hover_done(const std::string& problem, double now_s);

  const PlanningStatus& status() const { return status_; }
  const PlanningManagerConfig& config() const { return config_; }
  /// Rest of the flown trajectory, frame O; empty at rest.
  std::vector<geometry::Vec3> remaining_path(double now_s) const;

 private:
  struct Goal {
    geometry::Vec3 position_W;
    std::optional<double> heading_rad;
  };
  struct Job {
    std::uint64_t id;
    ActionKind stage;
    double begin_s;
    std::optional<double> start_stamp_s;
    bool is_shortening = false;
    PlanOutcome outcome;
    planning::Trajectory trajectory;
  };
  struct Flight {
    planning::Trajectory trajectory;
    double begin_s;
    double radius_m;
    bool is_to_goal;
    double left_m;            ///< from its end to the goal
    geometry::Vec3 goal_O;    ///< where the goal was in O when this was planned
    double ask_s;             ///< when the tracker was asked to fly it
    bool is_tracked = false;  ///< the tracker has been seen to fly it
  };

  // planning_manager.cpp: goals and states
  std::optional<std::string> foreign_command(double now_s);
  Actions lose(const std::string& problem, double now_s);
  void enter(PlannerState state, const std::string& reason);
  bool finish_if_reached(double now_s);
  Actions give_up(const std::string& reason, double now_s);
  void note_progress(double now_s);
  bool is_replan_due(double now_s) const;
  geometry::Vec3 goal_O() const;
  Actions start_plan(double now_s);
  void plan_failed(const std::string& problem, double now_s);
  bool is_worth_flying(const PlanOutcome& outcome, double now_s) const;

  // planning_flight.cpp: what is flown
  bool is_flying_trajectory(double now_s) const;
  double arc_now(double now_s) const;
  double speed() const { return inputs_.vehicle->value.velocity_O.norm(); }
  std::optional<planning::Trajectory> safe_part(const planning::Trajectory& trajectory, double from_arc_m,
                                                double radius_m, const View* view, std::string* problem) const;
  Actions publish(planning::Trajectory trajectory, const std::string& reason, double now_s);
  Actions hover(const std::string& reason, double now_s);

  PlanningManagerConfig config_;
  double min_altitude_m_;
  double max_altitude_m_;
  PlanningInputs inputs_;
  PlanningStatus status_;
  std::optional<Goal> goal_;
  std::optional<Job> job_;
  std::optional<Flight> flight_;
  std::optional<std::string> hover_wanted_;  ///< until the control manager has agreed
  double hover_sent_s_ = -1e18;
  std::optional<double> own_hover_s_;  ///< of voxnav's last hover, until the tracker has finished it
  bool was_in_control_ = false;        ///< the vehicle has been free to fly to the goal
  double next_plan_s_ = -1e18;
  double last_now_s_ = -1e18;
  std::uint64_t last_job_ = 0;
  geometry::Vec3 progress_O_ = geometry::Vec3::Zero();  ///< where the vehicle last got to
  double progress_s_ = -1e18;
};

}  // namespace voxnav::pipeline
