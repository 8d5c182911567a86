// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "path_smoothing.hpp"
#include "voxnav_simulation/speed_profile.hpp"
#include "voxnav_simulation/trajectory_generator.hpp"

namespace voxnav_simulation {

/// The result of one attempt to fly the waypoints.
struct Attempt {
  std::vector<Vec3> positions;  ///< smoothed positions, one per fine step
  std::vector<SpeedProfile::Sample>
      raw;  ///< raw[i + 2 * half] is averaged into positions[i] .. positions[i + 4 * half]
  std::vector<std::size_t> waypoint_vertices;
  double deviation_m = 0;
  int iterations = 0;
};

/// Generates the trajectory for one request with one width of smoothing.
class Generator {
 public:
  Generator(const TrajectoryGeneratorConfig& config, const PathRequest& request, double window_share)
      : config_(config),
        request_(request),
        limits_(request.limits.scaled(config.limit_ratio)),
        deviation_m_(request.max_deviation_m > 0 ? request.max_deviation_m : config.default_deviation_m),
        windows_(limits_, window_share * deviation_m_) {}

  GeneratedTrajectory run();

 private:
  std::string problem() const;
  void prepare();
  void settle_acceleration();
  std::vector<Vec3> vertices(double braking_ratio, std::vector<std::size_t>* waypoint_vertices) const;
  double corner_speed(const Polyline& path, std::size_t vertex) const;
  std::optional<Attempt> best_attempt(GeneratedTrajectory* out) const;
  std::optional<Attempt> attempt(double braking_ratio, bool stop_everywhere, bool* is_too_long) const;
  std::vector<double> reserves(const Polyline& path) const;
  bool fly(const Polyline& path, const SpeedProfile& profile, Attempt* out) const;
  std::vector<double> check(const Polyline& path, Attempt* attempt) const;
  bool slow_down(const std::vector<double>& ratios, const Attempt& attempt, SpeedProfile* profile) const;
  void finish(const Attempt& attempt, GeneratedTrajectory* out) const;
  std::vector<std::size_t> waypoint_steps(const Attempt& attempt, std::size_t offset) const;

  const TrajectoryGeneratorConfig& config_;
  const PathRequest& request_;
  TrackerLimits limits_;
  double deviation_m_;
  SmoothingWindows windows_;
  std::vector<HeadedPoint> waypoints_;
  std::vector<Vec3> lead_;        ///< fine samples during which the acceleration of the start state goes to zero
  Vec3 start_ = Vec3::Zero();     ///< position at the end of lead_
  Vec3 velocity_ = Vec3::Zero();  ///< velocity at start_
};

}  // namespace voxnav_simulation
