// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/movers.hpp"

#include <algorithm>
#include <cmath>

#include "streams.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {
namespace {

constexpr double kLineStep_m = 0.5;        ///< spacing of a line's points, which follow the ground
constexpr double kCrossing_m = 16.0;       ///< length of the way of one that crosses the line from start to goal
constexpr double kGreatestTurn_rad = 1.0;  ///< by which that way differs from square across
constexpr double kKeptAway_m = 4.0;        ///< from the clear places around start and goal

Mover person() {
  Mover out;
  out.surface_class = SurfaceClass::kPerson;
  out.radius_m = 0.25;
  out.height_m = 1.75;
  return out;
}

using WayPoints = std::vector<Vec3>;  // heights are above the ground

/// Gives a mover the closed line through way points at its speed.
Mover sent_along(Mover mover, const WayPoints& way, double speed_mps, const Terrain& terrain) {
  mover.speed_mps = speed_mps;
  double length_m = 0;
  const auto next = [&](std::size_t i) -> const Vec3& { return way[(i + 1) % way.size()]; };
  for (std::size_t i = 0; i < way.size(); ++i) length_m += (next(i) - way[i]).norm();
  const int count = std::max(1, static_cast<int>(std::lround(length_m / kLineStep_m)));
  mover.spacing_m = length_m / count;
  std::size_t leg = 0;
  double leg_begin_m = 0;
  for (int k = 0; k < count; ++k) {
    const double along_m = k * mover.spacing_m;
    while (leg + 1 < way.size() && along_m > leg_begin_m + (next(leg) - way[leg]).norm()) {
      leg_begin_m += (next(leg) - way[leg]).norm();
      ++leg;
    }
    const double leg_m = (next(leg) - way[leg]).norm();
    const double share = leg_m > 0 ? std::clamp((along_m - leg_begin_m) / leg_m, 0.0, 1.0) : 0.0;
    Vec3 p = way[leg] + share * (next(leg) - way[leg]);
    p.z() += terrain.height(p.x(), p.y()).value_or(0.0);
    mover.line.push_back(p);
  }
  return mover;
}

/// Sorts rows of numbers by their first one, the number of the mover. Each row holds `width` numbers.
std::vector<WayPoints> ways_of(const std::vector<double>& rows, std::size_t width) {
  std::vector<WayPoints> out;
  for (std::size_t i = 0; i + width <= rows.size(); i += width) {
    const auto mover = static_cast<std::size_t>(rows[i]);
    if (mover >= out.size()) out.resize(mover + 1);
    out[mover].emplace_back(rows[i + 1], rows[i + 2], width > 3 ? rows[i + 3] : 0.0);
  }
  return out;
}

/// Draws a way there and back across the line from start to goal.
WayPoints crossing(const WorldConfig& config, double height_m, Rng* random) {
  const Eigen::Vector2d start(config.start_m[0], config.start_m[1]), goal(config.goal_m[0], config.goal_m[1]);
  const double length_m = (goal - start).norm();
  const double kept_m = std::min(config.clear_radius_m + kKeptAway_m, 0.5 * length_m);
  const Eigen::Vector2d along = length_m > 0 ? Eigen::Vector2d((goal - start) / length_m) : Eigen::Vector2d(1, 0);
  const Eigen::Vector2d middle = start + random->uniform(kept_m, length_m - kept_m) * along;
  const double angle = std::atan2(along.x(), -along.y()) + random->uniform(-kGreatestTurn_rad, kGreatestTurn_rad);
  const Eigen::Vector2d half = 0.5 * kCrossing_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const auto at = [&](const Eigen::Vector2d& p) { return Vec3(p.x(), p.y(), height_m); };
  return {at(middle - half), at(middle + half)};
}

}  // namespace

Mover flyer() {
  Mover out;
  out.surface_class = SurfaceClass::kFlyer;
  out.radius_m = 0.35;
  out.height_m = 0.3;
  return out;
}

Vec3 Mover::at(voxnav::base::StampNs stamp_ns) const {
  const double turns = (begin_m + speed_mps * voxnav::base::to_seconds(stamp_ns)) / spacing_m;
  const auto count = static_cast<double>(line.size());
  const double place = turns - count * std::floor(turns / count);
  const auto i = std::min(static_cast<std::size_t>(place), line.size() - 1);
  return line[i] + (place - static_cast<double>(i)) * (line[(i + 1) % line.size()] - line[i]);
}

std::optional<CylinderHit> cast_at_cylinder(const Mover& mover, const Vec3& bottom, const Vec3& origin,
                                            const Vec3& direction) {
  const Eigen::Vector2d o = origin.head<2>() - bottom.head<2>(), d = direction.head<2>();
  const double above_m = origin.z() - bottom.z();
  std::optional<CylinderHit> best;
  const auto offer = [&](double range_m, double cosine) {
    if (range_m > 0 && cosine > 0 && (!best || range_m < best->range_m)) best = {range_m, cosine};
  };
  const double qa = d.squaredNorm(), qb = d.dot(o), qc = o.squaredNorm() - mover.radius_m * mover.radius_m;
  const double root = qb * qb - qa * qc;
  if (qa > 1e-12 && root >= 0) {
    const double range_m = (-qb - std::sqrt(root)) / qa;
    const double z = above_m + range_m * direction.z();
    if (z >= 0 && z <= mover.height_m) offer(range_m, -d.dot(o + range_m * d) / mover.radius_m);
  }
  if (std::abs(direction.z()) > 1e-9) {
    const double end_m = direction.z() > 0 ? 0.0 : mover.height_m;
    const double range_m = (end_m - above_m) / direction.z();
    if ((o + range_m * d).squaredNorm() <= mover.radius_m * mover.radius_m) offer(range_m, std::abs(direction.z()));
  }
  return best;
}

double distance_to_cylinder(const Mover& mover, const Vec3& bottom, const Vec3& p) {
  const double across_m = std::max(0.0, (p.head<2>() - bottom.head<2>()).norm() - mover.radius_m);
  const double z = p.z() - bottom.z();
  return std::hypot(across_m, std::max({0.0, -z, z - mover.height_m}));
}

std::vector<Mover> make_movers(const WorldConfig& config, std::uint64_t seed, const Terrain& terrain) {
  std::vector<Mover> out;
  for (const WayPoints& way : ways_of(config.walker_waypoints, 3)) {
    out.push_back(sent_along(person(), way, config.walker_speed_mps, terrain));
  }
  for (const WayPoints& way : ways_of(config.flyer_waypoints, 4)) {
    out.push_back(sent_along(flyer(), way, config.flyer_speed_mps, terrain));
  }
  Rng random(seed, kMoverStream);
  for (int i = 0; i < config.num_walkers + config.num_flyers; ++i) {
    const bool walks = i < config.num_walkers;
    const double height_m = random.uniform(1.5, 3.0);
    const WayPoints way = crossing(config, walks ? 0.0 : height_m, &random);
    Mover mover =
        sent_along(walks ? person() : flyer(), way, walks ? config.walker_speed_mps : config.flyer_speed_mps, terrain);
    mover.begin_m = random.uniform(0, 2.0 * kCrossing_m);
    out.push_back(std::move(mover));
  }
  return out;
}

}  // namespace voxnav_simulation
