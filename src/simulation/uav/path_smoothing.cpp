// SPDX-License-Identifier: BSD-3-Clause
#include "path_smoothing.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav_simulation {

SmoothingWindows::SmoothingWindows(const TrackerLimits& limits, double max_deviation_m) {
  const double a = limits.horizontal.acceleration;
  const double a_over_j = std::max(limits.horizontal.acceleration / limits.horizontal.jerk,
                                   limits.vertical_acceleration() / limits.vertical_jerk());
  // A corner of turn c that is taken at speed v with a window of width T deviates by v c T / 4 and needs the
  // acceleration 2 v c / T. Both reach their limits at this T. Acceleration along a straight line followed by braking
  // needs 2 a / T <= j.
  const double width_s = std::max({std::min(std::sqrt(8 * max_deviation_m / a), 1.0), 2 * a_over_j, 0.2});
  velocity_steps = static_cast<int>(std::ceil(0.5 * width_s / kFineStep_s));
  acceleration_steps = static_cast<int>(std::ceil(0.5 * std::max(1.5 * a_over_j, 0.1) / kFineStep_s));
}

double SmoothingWindows::mean_s() const {
  const double wide = std::max(velocity_steps, acceleration_steps) * 2.0 * kFineStep_s;
  const double narrow = std::min(velocity_steps, acceleration_steps) * 2.0 * kFineStep_s;
  return wide / 4 + narrow * narrow / (12 * wide);
}

std::vector<Vec3> moving_average(const std::vector<Vec3>& in, int half) {
  const std::size_t width = 2 * static_cast<std::size_t>(half) + 1;
  if (in.size() < width) return {};
  // Sums are relative to the first sample, so that large coordinates cost no precision.
  const Vec3& origin = in.front();
  std::vector<Vec3> sums(in.size() + 1, Vec3::Zero());
  for (std::size_t i = 0; i < in.size(); ++i) sums[i + 1] = sums[i] + (in[i] - origin);
  std::vector<Vec3> out;
  out.reserve(in.size() - width + 1);
  for (std::size_t i = 0; i + width <= in.size(); ++i) {
    out.emplace_back(origin + (sums[i + width] - sums[i]) / static_cast<double>(width));
  }
  return out;
}

namespace {

std::vector<Vec3> differences(const std::vector<Vec3>& in) {
  std::vector<Vec3> out;
  for (std::size_t i = 0; i + 1 < in.size(); ++i) out.emplace_back((in[i + 1] - in[i]) / kFineStep_s);
  return out;
}

void lower_ratios(const std::vector<Vec3>& values, double horizontal, double vertical, std::vector<double>* ratios) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double excess = std::max(values[i].head<2>().norm() / horizontal, std::abs(values[i].z()) / vertical);
    if (excess > 1) (*ratios)[i] = std::min((*ratios)[i], 1 / excess);
  }
}

}  // namespace

std::vector<double> limit_ratios(const std::vector<Vec3>& positions, const TrackerLimits& limits) {
  std::vector<double> ratios(positions.size(), 1.0);
  const std::vector<Vec3> accelerations = differences(differences(positions));
  lower_ratios(accelerations, limits.horizontal.acceleration, limits.vertical_acceleration(), &ratios);
  lower_ratios(differences(accelerations), limits.horizontal.jerk, limits.vertical_jerk(), &ratios);
  return ratios;
}

}  // namespace voxnav_simulation
