// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planning/flight_time.hpp"

namespace voxnav::planning {
namespace {

using geometry::Vec3;

constexpr int kStepsPerSample = 20;
constexpr int kMaxSamples = 2000;
/// Minimum speed on a braking curve, which in equal time steps would otherwise never quite reach its end.
constexpr double kCreepSpeed = 0.05;
/// Shorter segments and slower velocities do not determine a direction.
constexpr double kMinPiece_m = 1e-6;
constexpr double kMinSpeed_mps = 0.1;
/// Steps of a trajectory at constant speed differ by less than this share.
constexpr double kSpeedNoise = 1e-3;

}  // namespace

bool DynamicsLimits::is_valid() const {
  const double values[] = {horizontal_speed_mps,        horizontal_acceleration_mps2, ascending_speed_mps,
                           ascending_acceleration_mps2, descending_speed_mps,         descending_acceleration_mps2};
  return std::all_of(std::begin(values), std::end(values), [](double v) { return v > 0.0 && std::isfinite(v); });
}

Trajectory::Trajectory(std::vector<Vec3> points, double dt_s) : points_(std::move(points)), dt_s_(dt_s) {
  if (points_.empty()) throw std::invalid_argument("a trajectory needs at least one point");
  if (!(dt_s > 0.0) || !std::isfinite(dt_s)) throw std::invalid_argument("dt_s must be positive");
  for (const Vec3& point : points_) {
    if (!point.allFinite()) throw std::invalid_argument("trajectory holds a point that is not finite");
  }
  arcs_.assign(1, 0.0);
  for (std::size_t i = 1; i < points_.size(); ++i) {
    arcs_.push_back(arcs_.back() + (points_[i] - points_[i - 1]).norm());
  }
}

double Trajectory::arc_at(double time_s) const {
  const double at = std::min(std::max(0.0, time_s / dt_s_), static_cast<double>(points_.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(at), points_.size() - 1);
  if (i + 1 == points_.size()) return arcs_.back();
  return arcs_[i] + (at - static_cast<double>(i)) * (arcs_[i + 1] - arcs_[i]);
}

Vec3 Trajectory::position_at_arc(double arc_m) const {
  const auto after = std::upper_bound(arcs_.begin(), arcs_.end(), arc_m);
  if (after == arcs_.end()) return points_.back();
  if (after == arcs_.begin()) return points_.front();
  const auto i = static_cast<std::size_t>(after - arcs_.begin()) - 1;
  return points_[i] + (points_[i + 1] - points_[i]) * ((arc_m - arcs_[i]) / (arcs_[i + 1] - arcs_[i]));
}

Vec3 Trajectory::position_at(double time_s) const { return position_at_arc(arc_at(time_s)); }

double Trajectory::speed_at(double time_s) const {
  if (points_.size() < 2 || time_s >= duration_s()) return 0.0;
  const auto i = std::min(static_cast<std::size_t>(std::max(0.0, time_s / dt_s_)), points_.size() - 2);
  return (arcs_[i + 1] - arcs_[i]) / dt_s_;
}

double Trajectory::braking_begins_s() const {
  std::size_t i = points_.size() < 2 ? 0 : points_.size() - 1;
  const auto step = [this](std::size_t k) { return arcs_[k] - arcs_[k - 1]; };
  while (i >= 2 && step(i - 1) > step(i) * (1.0 + kSpeedNoise)) --i;
  return (i == 0 ? 0.0 : static_cast<double>(i - 1)) * dt_s_;
}

double Trajectory::speed_at_arc(double arc_m) const {
  const auto after = std::upper_bound(arcs_.begin(), arcs_.end(), arc_m);
  if (after == arcs_.end() || after == arcs_.begin()) return 0.0;
  return (*after - *(after - 1)) / dt_s_;
}

double Trajectory::project(const Vec3& position, double from_s, double to_s) const {
  double best_arc = arc_at(from_s);
  double best = (position_at_arc(best_arc) - position).squaredNorm();
  const auto first = static_cast<std::size_t>(std::max(0.0, std::floor(from_s / dt_s_)));
  for (std::size_t i = first; i + 1 < points_.size() && static_cast<double>(i) * dt_s_ <= to_s; ++i) {
    const Vec3 piece = points_[i + 1] - points_[i];
    const double length_sq = piece.squaredNorm();
    const double t = length_sq > 0.0 ? std::min(1.0, std::max(0.0, piece.dot(position - points_[i]) / length_sq)) : 0.0;
    const double d = (points_[i] + t * piece - position).squaredNorm();
    if (d >= best) continue;
    best = d;
    best_arc = arcs_[i] + t * std::sqrt(length_sq);
  }
  return best_arc;
}

std::vector<Vec3> Trajectory::points_from_arc(double arc_m) const {
  std::vector<Vec3> out = {position_at_arc(arc_m)};
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (arcs_[i] > arc_m) out.push_back(points_[i]);
  }
  return out;
}

std::optional<Trajectory> Trajectory::stopped_at(double from_arc_m, double stop_arc_m, double deceleration_mps2) const {
  const double end = std::min(stop_arc_m, length_m());
  const double start_speed = speed_at_arc(from_arc_m);
  if (end - from_arc_m < start_speed * start_speed / (2.0 * deceleration_mps2)) return std::nullopt;
  std::vector<Vec3> points = {position_at_arc(from_arc_m)};
  const double step_s = dt_s_ / kStepsPerSample;
  double arc = from_arc_m;
  for (int sample = 0; sample < kMaxSamples && arc < end; ++sample) {
    for (int step = 0; step < kStepsPerSample && arc < end; ++step) {
      const double braking = std::sqrt(2.0 * deceleration_mps2 * (end - arc));
      arc = std::min(end, arc + std::max(kCreepSpeed, std::min(speed_at_arc(arc), braking)) * step_s);
    }
    points.push_back(position_at_arc(arc));
  }
  return Trajectory(std::move(points), dt_s_);
}

double braking_deceleration(const Trajectory& trajectory, double from_arc_m, double to_arc_m, const Vec3& velocity,
                            const DynamicsLimits& limits) {
  DynamicsLimits braking = limits;
  braking.ascending_acceleration_mps2 = braking.descending_acceleration_mps2 =
      std::min(limits.ascending_acceleration_mps2, limits.descending_acceleration_mps2);
  double out = limits_along(Vec3::UnitX(), braking).acceleration_mps2;
  const auto allow_for = [&](const Vec3& direction, double min_norm) {
    if (direction.norm() > min_norm) out = std::min(out, limits_along(direction, braking).acceleration_mps2);
  };
  allow_for(velocity, kMinSpeed_mps);
  const std::vector<Vec3> points = trajectory.points_from_arc(from_arc_m);
  double arc_m = from_arc_m;
  for (std::size_t i = 1; i < points.size() && arc_m < to_arc_m; ++i) {
    allow_for(points[i] - points[i - 1], kMinPiece_m);
    arc_m += (points[i] - points[i - 1]).norm();
  }
  return out;
}

double stopping_distance(double speed_mps, double deceleration_mps2, double reaction_s) {
  return speed_mps * speed_mps / (2.0 * deceleration_mps2) + speed_mps * reaction_s;
}

}  // namespace voxnav::planning
