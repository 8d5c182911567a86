// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/bumper.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav_simulation {
namespace {

constexpr int kRaysAcross = 5;      ///< of one sector, and three rows of them
constexpr double kStopShare = 1.5;  ///< by which the way to stop is counted, as the control manager does
constexpr double kTwoPi = 2.0 * M_PI;

double way_to_stop(double speed, double acceleration) { return 0.5 * speed * speed / acceleration; }

double vertical_way_to_stop(const TrackerLimits& limits) {
  return way_to_stop(std::max(limits.ascending.speed, limits.descending.speed),
                     std::max(limits.ascending.acceleration, limits.descending.acceleration));
}

}  // namespace

Bumper::Bumper(const BumperConfig& config) : config_(voxnav::base::checked(config)) {}

std::optional<double> Bumper::sector_range(const Range& range, double direction_rad, double max_m) const {
  std::optional<double> nearest;
  for (int i = 0; i < kRaysAcross; ++i) {
    const double azimuth =
        direction_rad + (static_cast<double>(i) / (kRaysAcross - 1) - 0.5) * kTwoPi / config_.num_sectors;
    for (const double elevation : {-0.5 * config_.vertical_fov_rad, 0.0, 0.5 * config_.vertical_fov_rad}) {
      const Vec3 direction(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                           std::sin(elevation));
      const auto found = range(direction, nearest.value_or(max_m));
      if (found) nearest = found;
    }
  }
  return nearest;
}

Bumper::Reach Bumper::reach(const TrackerLimits& limits) const {
  const double more = config_.is_derived_from_dynamics ? kStopShare : 0.0;
  return {config_.min_distance_m + more * way_to_stop(limits.horizontal.speed, limits.horizontal.acceleration),
          config_.min_distance_m + more * vertical_way_to_stop(limits)};
}

std::optional<Vec3> Bumper::push(const Range& range, double heading_rad, const TrackerLimits& limits) const {
  const Reach near = reach(limits);
  SectorRanges sectors;
  double nearest_m = near.across_m;  // what is farther than this decides nothing, and rays to there cost less
  for (int i = 0; i < config_.num_sectors; ++i) {
    sectors.horizontal_m.push_back(sector_range(range, heading_rad + kTwoPi * i / config_.num_sectors, nearest_m));
    nearest_m = sectors.horizontal_m.back().value_or(nearest_m);
  }
  sectors.below_m = range(-Vec3::UnitZ(), near.along_m);
  sectors.above_m = range(Vec3::UnitZ(), near.along_m);
  return push(sectors, heading_rad, near);
}

std::optional<Vec3> Bumper::push(const SectorRanges& sectors, double heading_rad, const TrackerLimits& limits) const {
  return push(sectors, heading_rad, reach(limits));
}

std::optional<Vec3> Bumper::push(const SectorRanges& sectors, double heading_rad, const Reach& near) const {
  std::optional<double> nearest_m;
  double towards_rad = 0;
  for (std::size_t i = 0; i < sectors.horizontal_m.size(); ++i) {
    const auto& found_m = sectors.horizontal_m[i];
    if (!found_m || *found_m >= nearest_m.value_or(near.across_m)) continue;
    nearest_m = found_m;
    towards_rad = heading_rad + kTwoPi * static_cast<double>(i) / static_cast<double>(sectors.horizontal_m.size());
  }
  const auto is_near = [&](const std::optional<double>& range_m) { return range_m && *range_m < near.along_m; };
  if (!nearest_m && !is_near(sectors.below_m) && !is_near(sectors.above_m)) return std::nullopt;
  Vec3 out = Vec3::Zero();
  if (nearest_m) {
    const double way_m = near.across_m + config_.overshoot_m - *nearest_m;
    out = -way_m * Vec3(std::cos(towards_rad), std::sin(towards_rad), 0);
  }
  if (is_near(sectors.below_m)) out.z() = near.along_m - *sectors.below_m;
  if (is_near(sectors.above_m)) out.z() = -(near.along_m - *sectors.above_m);
  return out;
}

}  // namespace voxnav_simulation
