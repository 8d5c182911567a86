// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav_simulation/speed_profile.hpp"

namespace voxnav_simulation {

constexpr double kFineStep_s = 0.01;

/// The half widths, in fine steps, of the two windows over which positions are averaged.
struct SmoothingWindows {
  SmoothingWindows(const TrackerLimits& limits, double max_deviation_m);
  int velocity_steps;      ///< window that bounds the acceleration at corners
  int acceleration_steps;  ///< window that bounds the jerk
  int steps() const { return velocity_steps + acceleration_steps; }
  double width_s() const { return (2 * velocity_steps + 1) * kFineStep_s; }
  double half_s() const { return steps() * kFineStep_s; }
  /// Returns the mean distance in time of the averaged samples. A corner is cut by this times the speed times
  /// Polyline::turn().
  double mean_s() const;
};

/// Averages over 2 * half + 1 neighbours. The result has 2 * half samples fewer than the input.
std::vector<Vec3> moving_average(const std::vector<Vec3>& in, int half);

/// Returns for each sample the share of its present speed that would respect the limits of acceleration and jerk, which
/// is 1 where they are respected already.
std::vector<double> limit_ratios(const std::vector<Vec3>& positions, const TrackerLimits& limits);

}  // namespace voxnav_simulation
