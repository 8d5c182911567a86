// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/trajectory_generator.hpp"

#include <algorithm>
#include <cmath>

#include "heading_profile.hpp"
#include "trajectory_attempt.hpp"

namespace voxnav_simulation {

GeneratedTrajectory Generator::run() {
  GeneratedTrajectory out;
  out.message = problem();
  if (!out.message.empty()) return out;
  prepare();
  const std::optional<Attempt> attempt = best_attempt(&out);
  if (!attempt) {
    out.message = "the path takes longer than " + std::to_string(config_.max_duration_s) + " s";
    return out;
  }
  finish(*attempt, &out);
  return out;
}

std::string Generator::problem() const {
  if (request_.waypoints.empty()) return "the path is empty";
  if (request_.waypoints.size() > static_cast<std::size_t>(config_.max_waypoints)) {
    return "the path has more than " + std::to_string(config_.max_waypoints) + " waypoints";
  }
  for (const HeadedPoint& point : request_.waypoints) {
    if (!is_finite(point)) return "the path contains a value that is not finite";
  }
  if (request_.start && !is_finite(*request_.start)) return "the start state is not finite";
  if (!(deviation_m_ >= 0.01)) return "the allowed deviation from the path is below 0.01 m or not a number";
  const auto positive = [](const TrackerAxisLimits& l) { return l.speed > 0 && l.acceleration > 0 && l.jerk > 0; };
  if (!positive(limits_.horizontal) || !positive(limits_.ascending) || !positive(limits_.descending) ||
      !positive(limits_.heading)) {
    return "the constraints are not positive";
  }
  return {};
}

void Generator::prepare() {
  waypoints_ = request_.waypoints;
  if (request_.is_loop) waypoints_.push_back(waypoints_.front());
  start_ = request_.start ? request_.start->position : waypoints_.front().position;
  if (request_.start) settle_acceleration();
}

/// Reduces the acceleration to zero with constant jerk, because what follows assumes a start at constant velocity.
void Generator::settle_acceleration() {
  const KinematicState& s = *request_.start;
  const double needed_s = std::max(s.acceleration.head<2>().norm() / limits_.horizontal.jerk,
                                   std::abs(s.acceleration.z()) / limits_.vertical_jerk());
  const auto steps = static_cast<int>(std::ceil(needed_s / kFineStep_s - 1e-9));
  velocity_ = s.velocity;
  if (steps == 0) return;
  const double total = steps * kFineStep_s;
  for (int i = 0; i <= steps; ++i) {
    const double t = i * kFineStep_s;
    start_ = s.position + s.velocity * t + s.acceleration * (0.5 * t * t - t * t * t / (6 * total));
    if (i < steps) lead_.push_back(start_);
  }
  velocity_ = s.velocity + 0.5 * total * s.acceleration;
}

std::optional<Attempt> Generator::attempt(double braking_ratio, bool stop_everywhere, bool* is_too_long) const {
  Attempt out;
  const Polyline path(vertices(braking_ratio, &out.waypoint_vertices));
  if (path.vertices().size() < 2) {  // all waypoints are where the vehicle is
    const auto half = static_cast<std::size_t>(windows_.steps());
    if (velocity_.norm() > 1e-3) return std::nullopt;
    out.raw.assign(2 * half + 1, {path.vertices().front(), 0, 0});
    out.positions.assign(1, path.vertices().front());
    return out;
  }
  const double speed = velocity_.norm();
  if (speed > 1e-3 && braking_ratio < 1 && speed > corner_speed(path, 0)) return std::nullopt;
  SpeedProfile profile(path, limits_, reserves(path));
  for (std::size_t i = 1; i + 1 < path.vertices().size(); ++i) {
    profile.cap_vertex(i, stop_everywhere ? 0 : corner_speed(path, i));
  }
  if (request_.stop_at_waypoints) {
    for (const std::size_t vertex : out.waypoint_vertices) profile.cap_vertex(vertex, 0);
  }
  for (out.iterations = 1; out.iterations <= config_.max_iterations; ++out.iterations) {
    if (!profile.solve(speed)) return std::nullopt;
    if (!fly(path, profile, &out)) {
      *is_too_long = true;
      return std::nullopt;
    }
    const bool has_changed = slow_down(check(path, &out), out, &profile);
    if (!has_changed || stop_everywhere) return out;
  }
  return std::nullopt;
}

std::optional<Attempt> Generator::best_attempt(GeneratedTrajectory* out) const {
  bool is_too_long = false;
  const bool is_moving = velocity_.norm() > 1e-3;
  for (const double braking_ratio : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    if (auto result = attempt(braking_ratio, false, &is_too_long)) return result;
    if (is_too_long) return std::nullopt;
    if (!is_moving) break;
  }
  out->stops_at_corners = true;
  return attempt(1.0, true, &is_too_long);
}

/// Returns the fine step at which the trajectory is nearest to each waypoint. It is searched along the line before the
/// waypoint: as averages are centred, the unsmoothed point is near the waypoint at the same step.
std::vector<std::size_t> Generator::waypoint_steps(const Attempt& attempt, std::size_t offset) const {
  const auto half = static_cast<std::size_t>(windows_.steps());
  std::vector<std::size_t> out;
  std::size_t step = 0;
  for (const HeadedPoint& waypoint : waypoints_) {
    std::size_t best = step;
    const std::size_t vertex = attempt.waypoint_vertices[out.size()];
    for (std::size_t i = step; i < attempt.positions.size(); ++i) {
      if (attempt.raw[i + half].segment > vertex) break;
      if ((attempt.positions[i] - waypoint.position).norm() < (attempt.positions[best] - waypoint.position).norm())
        best = i;
    }
    step = best;
    out.push_back(best + offset);
  }
  return out;
}

void Generator::finish(const Attempt& attempt, GeneratedTrajectory* out) const {
  std::vector<Vec3> positions = lead_;
  positions.insert(positions.end(), attempt.positions.begin(), attempt.positions.end());
  const std::vector<std::size_t> steps = waypoint_steps(attempt, lead_.size());
  const std::vector<double> headings = heading_profile(request_, waypoints_, limits_.heading, steps, &positions);
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::round(config_.sampling_s / kFineStep_s)));
  out->dt_s = static_cast<double>(stride) * kFineStep_s;
  for (std::size_t i = 0; i < positions.size() + stride - 1; i += stride) {
    const std::size_t k = std::min(i, positions.size() - 1);
    out->samples.push_back({positions[k], headings[k]});
  }
  for (const std::size_t step : steps)
    out->waypoint_samples.push_back(std::min((step + stride / 2) / stride, out->samples.size() - 1));
  out->duration_s = static_cast<double>(positions.size() - 1) * kFineStep_s;
  out->deviation_m = attempt.deviation_m;
  out->iterations = attempt.iterations;
  out->is_valid = true;
}

GeneratedTrajectory generate_trajectory(const TrajectoryGeneratorConfig& config, const PathRequest& request) {
  // Corners are faster with wide windows, starts and stops with narrow ones, so both are tried.
  GeneratedTrajectory wide = Generator(config, request, 1.0).run();
  if (!wide.is_valid) return wide;
  GeneratedTrajectory narrow = Generator(config, request, 0.2).run();
  if (!narrow.is_valid) return wide;
  return narrow.duration_s < wide.duration_s ? narrow : wide;
}

}  // namespace voxnav_simulation
