// SPDX-License-Identifier: BSD-3-Clause
#include "planning/flight_time.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::planning {
namespace {

using geometry::Vec3;

constexpr double kTiny = 1e-9;
constexpr int kCutBisections = 40;

/// Returns the squared speed at which the corner between two segments may be passed.
double corner_speed_sq(const Vec3& before, const Vec3& after, double acceleration, double tolerance_m) {
  const double cosine = before.dot(after) / std::max(kTiny, before.norm() * after.norm());
  // The interior angle of the corner; it is pi for a straight line.
  const double half_angle = 0.5 * (M_PI - std::acos(std::min(1.0, std::max(-1.0, cosine))));
  const double s = std::sin(half_angle);
  if (s > 1.0 - 1e-6) return std::numeric_limits<double>::infinity();
  return acceleration * tolerance_m * s / (1.0 - s);
}

/// Returns the time to fly a segment with the given squared speeds at its ends.
double piece_time(double length, double entry_sq, double exit_sq, const AxisLimits& limits) {
  if (length < kTiny) return 0.0;
  const double a = limits.acceleration_mps2;
  const double peak_sq = std::min(limits.speed_mps * limits.speed_mps, 0.5 * (2.0 * a * length + entry_sq + exit_sq));
  const double peak = std::sqrt(peak_sq);
  const double ramps = (2.0 * peak_sq - entry_sq - exit_sq) / (2.0 * a);
  return (2.0 * peak - std::sqrt(entry_sq) - std::sqrt(exit_sq)) / a + std::max(0.0, length - ramps) / peak;
}

}  // namespace

AxisLimits limits_along(const Vec3& direction, const DynamicsLimits& limits) {
  const double norm = std::max(kTiny, direction.norm());
  const double horizontal = std::max(kTiny, direction.head<2>().norm() / norm);
  const double vertical = std::max(kTiny, std::abs(direction.z()) / norm);
  const bool is_up = direction.z() >= 0.0;
  const double v_speed = is_up ? limits.ascending_speed_mps : limits.descending_speed_mps;
  const double v_acceleration = is_up ? limits.ascending_acceleration_mps2 : limits.descending_acceleration_mps2;
  return {std::min(limits.horizontal_speed_mps / horizontal, v_speed / vertical),
          std::min(limits.horizontal_acceleration_mps2 / horizontal, v_acceleration / vertical)};
}

double rest_to_rest_time(double length_m, const AxisLimits& limits) { return piece_time(length_m, 0.0, 0.0, limits); }

std::vector<double> passing_times(const std::vector<Vec3>& points, const DynamicsLimits& limits,
                                  double corner_tolerance_m) {
  const std::size_t n = points.size();
  std::vector<double> times(n, 0.0);
  if (n < 2) return times;
  std::vector<AxisLimits> along(n - 1);
  std::vector<double> speed_sq(n, 0.0);
  for (std::size_t i = 0; i + 1 < n; ++i) along[i] = limits_along(points[i + 1] - points[i], limits);
  const auto length = [&](std::size_t i) { return (points[i + 1] - points[i]).norm(); };
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double acceleration = std::min(along[i - 1].acceleration_mps2, along[i].acceleration_mps2);
    const double speed = std::min(along[i - 1].speed_mps, along[i].speed_mps);
    speed_sq[i] = std::min(speed * speed, corner_speed_sq(points[i] - points[i - 1], points[i + 1] - points[i],
                                                          acceleration, corner_tolerance_m));
    speed_sq[i] = std::min(speed_sq[i], speed_sq[i - 1] + 2.0 * along[i - 1].acceleration_mps2 * length(i - 1));
  }
  for (std::size_t i = n - 1; i-- > 0;) {
    speed_sq[i] = std::min(speed_sq[i], speed_sq[i + 1] + 2.0 * along[i].acceleration_mps2 * length(i));
  }
  for (std::size_t i = 0; i + 1 < n; ++i) {
    times[i + 1] = times[i] + piece_time(length(i), speed_sq[i], speed_sq[i + 1], along[i]);
  }
  return times;
}

double length_of(const std::vector<Vec3>& points) {
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

double flight_time(const std::vector<Vec3>& points, const DynamicsLimits& limits, double corner_tolerance_m) {
  return points.size() < 2 ? 0.0 : passing_times(points, limits, corner_tolerance_m).back();
}

std::vector<Vec3> cut_at_length(const std::vector<Vec3>& points, double length_m) {
  std::vector<Vec3> out;
  double left = std::max(0.0, length_m);
  for (const Vec3& point : points) {
    if (!out.empty()) {
      const double piece = (point - out.back()).norm();
      if (piece >= left) {
        if (piece > kTiny) out.emplace_back(out.back() + (point - out.back()) * (left / piece));
        return out;
      }
      left -= piece;
    }
    out.push_back(point);
  }
  return out;
}

std::vector<Vec3> cut_at_time(const std::vector<Vec3>& points, const DynamicsLimits& limits, double corner_tolerance_m,
                              double max_time_s) {
  const auto time_of = [&](const std::vector<Vec3>& line) {
    return passing_times(line, limits, corner_tolerance_m).back();
  };
  if (points.size() < 2 || time_of(points) <= max_time_s) return points;
  double low = 0.0, high = length_of(points);
  for (int i = 0; i < kCutBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (time_of(cut_at_length(points, middle)) <= max_time_s ? low : high) = middle;
  }
  return cut_at_length(points, low);
}

}  // namespace voxnav::planning
