// SPDX-License-Identifier: BSD-3-Clause
// The parts of an attempt at a trajectory: its lines, its speeds, and the check against the limits.
#include "trajectory_attempt.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav_simulation {
namespace {

constexpr double kTolerance = 1e-3;     ///< share by which limits may be exceeded, for rounding
constexpr double kMinSegment_m = 1e-3;  ///< waypoints that are nearer to each other count as one
constexpr double kBrakingShare = 0.55;  ///< share of the acceleration used to brake before the path begins
constexpr double kStraight = 0.03;      ///< turns smaller than this need no reserve of acceleration
constexpr double kCornerShare = 0.75;   ///< share of the acceleration in the first guess of the speed at corners

}  // namespace

/// Returns the vertices of the straight lines that are flown: the end of the smoothing's half width at constant
/// velocity, the end of the share `braking_ratio` of the braking distance straight on, and the waypoints. Waypoints
/// that were reached before the first vertex are left out.
std::vector<Vec3> Generator::vertices(double braking_ratio, std::vector<std::size_t>* waypoint_vertices) const {
  std::vector<Vec3> out{start_ + velocity_ * windows_.half_s()};
  const double speed = velocity_.norm();
  if (braking_ratio > 0 && speed > 0) {
    const Vec3 direction = velocity_ / speed;
    const double braking = kBrakingShare * std::min(limits_.horizontal.acceleration, limits_.vertical_acceleration());
    const double length = braking_ratio * speed * speed / (2 * braking);
    if (length > kMinSegment_m) out.emplace_back(out.back() + direction * length);
  }
  const Polyline begin({start_ - Vec3(1e-6, 0, 0), out.back()});
  bool has_left = false;
  for (const HeadedPoint& waypoint : waypoints_) {
    const bool is_passed = !has_left && begin.distance(waypoint.position, 0, 0) < 0.5 * deviation_m_;
    const bool is_last = &waypoint == &waypoints_.back();
    has_left = has_left || !is_passed;
    if ((!is_passed || is_last) && (waypoint.position - out.back()).norm() > kMinSegment_m) {
      out.push_back(waypoint.position);
    }
    waypoint_vertices->push_back(out.size() - 1);
  }
  return out;
}

double Generator::corner_speed(const Polyline& path, std::size_t vertex) const {
  Vec3 before = vertex > 0 ? path.direction(vertex - 1) : velocity_;
  if (vertex == 0 && before.norm() > 1e-9) before.normalize();
  const Vec3 change = path.direction(vertex) - before;  // the change of velocity per unit of speed
  const double turn = 0.5 * change.norm();
  if (turn < 1e-6) return limits_.horizontal.speed + limits_.ascending.speed + velocity_.norm();
  const double budget = kCornerShare * windows_.width_s();
  const double horizontal = budget * limits_.horizontal.acceleration / std::max(change.head<2>().norm(), 1e-9);
  const double vertical = budget * limits_.vertical_acceleration() / std::max(std::abs(change.z()), 1e-9);
  return std::min({deviation_m_ / (turn * windows_.mean_s()), horizontal, vertical});
}

/// Returns the distance from each vertex within which its turn needs acceleration: what the vehicle flies in half a
/// window if it accelerates from the speed of the corner.
std::vector<double> Generator::reserves(const Polyline& path) const {
  std::vector<double> out(path.vertices().size(), 0.0);
  const double half_s = 0.5 * windows_.width_s();
  for (std::size_t i = 1; i + 1 < out.size(); ++i) {
    if (path.turn(i) < kStraight) continue;
    const double speed = std::min(corner_speed(path, i), limits_.horizontal.speed);
    out[i] = half_s * (speed + 0.5 * half_s * limits_.horizontal.acceleration);
  }
  return out;
}

bool Generator::fly(const Polyline& path, const SpeedProfile& profile, Attempt* out) const {
  const auto half = static_cast<std::size_t>(windows_.steps());
  const auto max_samples = static_cast<std::size_t>(config_.max_duration_s / kFineStep_s);
  const auto samples = profile.sample(kFineStep_s, 2 * windows_.half_s(), max_samples);
  if (samples.empty()) return false;
  out->raw.clear();
  for (std::size_t i = 0; i < 2 * half; ++i) {
    const double t = (static_cast<double>(i) - static_cast<double>(half)) * kFineStep_s;
    out->raw.push_back({start_ + velocity_ * t, 0, 0});
  }
  out->raw.insert(out->raw.end(), samples.begin(), samples.end());
  out->raw.insert(out->raw.end(), 2 * half, {path.vertices().back(), path.num_segments() - 1, path.length_m()});
  std::vector<Vec3> positions;
  positions.reserve(out->raw.size());
  for (const auto& sample : out->raw) positions.push_back(sample.position);
  out->positions = moving_average(moving_average(positions, windows_.velocity_steps), windows_.acceleration_steps);
  return true;
}

/// Returns for each sample of the attempt the share of its present speed that would respect every limit.
std::vector<double> Generator::check(const Polyline& path, Attempt* attempt) const {
  std::vector<double> ratios = limit_ratios(attempt->positions, limits_);
  const auto window = 2 * static_cast<std::size_t>(windows_.steps());
  const Polyline begin({start_ - Vec3(1e-6, 0, 0), path.vertices().front()});
  attempt->deviation_m = 0;
  for (std::size_t i = 0; i < attempt->positions.size(); ++i) {
    double distance = path.distance(attempt->positions[i], attempt->raw[i].segment, attempt->raw[i + window].segment);
    if (i < window) distance = std::min(distance, begin.distance(attempt->positions[i], 0, 0));
    attempt->deviation_m = std::max(attempt->deviation_m, distance);
    if (distance > deviation_m_) ratios[i] = std::min(ratios[i], deviation_m_ / distance);
  }
  // The trajectory must also pass near the corner itself, from which it is farther away than from either line.
  for (std::size_t i = 0; i < attempt->positions.size(); ++i) {
    const SpeedProfile::Sample& centre = attempt->raw[i + window / 2];
    const SpeedProfile::Sample& next = attempt->raw[i + window / 2 + 1];
    if (next.segment == centre.segment) continue;
    const Vec3& corner = path.vertices()[next.segment];
    const double distance = (attempt->positions[i] - corner).norm();
    const double turn = path.turn(next.segment);
    if (turn > 1e-3 && distance > deviation_m_) ratios[i] = std::min(ratios[i], deviation_m_ / distance);
  }
  return ratios;
}

/// Lowers the speed wherever samples break a limit. @return false if no sample does
bool Generator::slow_down(const std::vector<double>& ratios, const Attempt& attempt, SpeedProfile* profile) const {
  const auto window = 2 * static_cast<std::size_t>(windows_.steps());
  bool has_changed = false;
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    if (ratios[i] >= 1 - kTolerance) continue;
    std::size_t last = i;
    double ratio = ratios[i];
    while (last + 1 < ratios.size() && ratios[last + 1] < 1 - kTolerance) ratio = std::min(ratio, ratios[++last]);
    profile->scale_caps(attempt.raw[i].arc_m, attempt.raw[last + window].arc_m, std::clamp(0.98 * ratio, 0.5, 0.97));
    has_changed = true;
    i = last;
  }
  return has_changed;
}

}  // namespace voxnav_simulation
