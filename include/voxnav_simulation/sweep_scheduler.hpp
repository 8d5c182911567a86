// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "voxnav_simulation/lidar_model.hpp"
#include "voxnav_simulation/pose_history.hpp"

namespace voxnav_simulation {

/// A turn of the sensor whose poses are all known, so that it can be measured.
struct SimulatedSweep {
  voxnav::base::StampNs start_ns = 0;
  std::uint64_t index = 0;  ///< number of the turn since stamp 0: the same whenever the simulator was started
  std::vector<Pose> T_W_L;  ///< one per column
};

struct SweepCounts {
  std::uint64_t poses_refused = 0;  ///< not a finite rigid transform
  std::uint64_t time_jumps = 0;     ///< stamps that went back
  std::uint64_t truth_gaps = 0;     ///< poses too far apart to know the motion between them
};

/// Schedules turns of a sensor from a stream of true body poses. It goes by stamps alone, so that the result is the
/// same at any speed of the clock. Turns start at whole multiples of the duration of one turn. Not thread-safe.
class SweepScheduler {
 public:
  /// @param is_instantaneous  whether all columns see the pose at the start of the turn, as in Gazebo
  SweepScheduler(const LidarModel& model, bool is_instantaneous);
  /// For a sensor that measures at one instant, once in each period.
  SweepScheduler(voxnav::base::StampNs period_ns, const Pose& T_B_L);

  void add_truth(const voxnav::geometry::StampedPose& T_W_B);
  /// Returns the next turn that the true poses cover completely, or nothing if there is none yet.
  std::optional<SimulatedSweep> next();
  const SweepCounts& counts() const { return counts_; }

 private:
  void restart();

  voxnav::base::StampNs period_ns_;
  std::vector<voxnav::base::StampNs> column_times_ns_;  ///< after the start of a turn
  Pose T_B_L_;
  PoseHistory history_;
  std::optional<std::int64_t> next_index_;
  SweepCounts counts_;
};

}  // namespace voxnav_simulation
