// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "voxnav_simulation/dynamics_limits.hpp"
#include "voxnav_simulation/kinematic_state.hpp"
#include "voxnav_simulation/spline.hpp"

namespace voxnav_simulation {

/// Duration of one step of the simulated vehicle; predictions and stamps are multiples of it.
constexpr double kStep_s = 0.005;
constexpr std::int64_t kStep_ns = 5'000'000;

/// A trajectory to follow, whose time starts when it is handed to the tracker.
struct TrackedTrajectory {
  std::vector<HeadedPoint> points;
  double dt_s = 0.2;
  double skip_s = 0;  ///< time of the trajectory that has passed already when it is handed over
  bool use_heading = true;
  bool is_loop = false;
  std::int64_t input_id = 0;
};

enum class TrackerMode { kHold, kBrake, kGoal, kTrajectory };

/// Follows goals and trajectories within the limits, like the MPC tracker of the MRS system: the motion respects the
/// limits of speed, acceleration and jerk whatever the reference. States are computed ahead, so that the prediction is
/// exact until the next command. Not thread-safe.
class Tracker {
 public:
  explicit Tracker(const TrackerLimits& limits);

  void set_limits(const TrackerLimits& limits);
  const TrackerLimits& limits() const { return limits_; }

  /// Jumps to this state without regard to the limits, which is for a vehicle on the ground.
  void reset(const KinematicState& state);
  void go_to(const HeadedPoint& goal);
  void brake();
  void follow(const TrackedTrajectory& trajectory);
  /// Raises the reference to a least height, and leaves a share of the horizontal speed limit; as for flying over
  /// another UAV. The trajectory goes on meanwhile.
  void set_floor(std::optional<double> floor_m, double speed_ratio);
  /// Moves state, goal and trajectory by a jump of their frame.
  void shift(const Vec3& jump);

  void step();
  KinematicState state() const { return now_.state; }
  TrackerMode mode() const { return now_.mode; }
  bool has_goal() const { return mode() == TrackerMode::kGoal || mode() == TrackerMode::kTrajectory; }
  HeadedPoint goal() const;
  std::size_t trajectory_index() const;
  std::size_t trajectory_size() const { return trajectory_ ? trajectory_->spline.size() : 0; }
  /// The number of the last trajectory, which a goal does not change, as in the MPC tracker of the MRS system.
  std::int64_t input_id() const { return input_id_; }

  /// Returns the state `num_steps` steps ahead, at most kMaxSteps. It is computed on the first call and then kept.
  const KinematicState& predicted(std::size_t num_steps);
  static constexpr std::size_t kMaxSteps = 2000;

 private:
  struct Motion {
    KinematicState state;
    TrackerMode mode = TrackerMode::kHold;
    HeadedPoint goal;
    double time_s = 0;  ///< time since the beginning of the trajectory
  };
  struct Followed {
    Spline spline;
    bool use_heading;
    bool is_loop;
    Vec3 offset = Vec3::Zero();  ///< by which the frame has jumped since
  };
  Motion next(const Motion& motion) const;
  void update_mode(Motion* motion) const;

  TrackerLimits limits_;
  std::shared_ptr<const Followed> trajectory_;
  std::optional<double> floor_m_;
  double speed_ratio_ = 1.0;
  std::int64_t input_id_ = 0;
  Motion now_;
  std::deque<Motion> ahead_;  ///< ahead_[i] is i + 1 steps ahead
};

}  // namespace voxnav_simulation
