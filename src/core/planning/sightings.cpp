// SPDX-License-Identifier: BSD-3-Clause
#include "planning/sightings.hpp"

#include <algorithm>
#include <cmath>

#include "planning/segment_box.hpp"

namespace voxnav::planning {
namespace {

using containers::MovingThing;
using geometry::Vec3;

/// Meetings are looked for at times that are not farther apart than this.
constexpr double kStep_s = 0.05;

/// The part of a line between two of its points, with times after the stamp of the things.
struct TimedPiece {
  Vec3 from, to;
  double from_s, to_s;
};

/// Returns the share of a piece that is flown before the vehicle may touch a thing; nothing if it does not.
std::optional<double> meeting_on(const TimedPiece& piece, const MovingThing& thing, const MovingRules& rules,
                                 double radius_m) {
  const int steps = std::max(1, static_cast<int>(std::ceil((piece.to_s - piece.from_s) / kStep_s)));
  for (int i = 0; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    const double after_s = piece.from_s + share * (piece.to_s - piece.from_s);
    if (after_s > rules.horizon_s) return std::nullopt;
    if (may_touch(thing, rules, after_s, piece.from + share * (piece.to - piece.from), radius_m)) return share;
  }
  return std::nullopt;
}

}  // namespace

bool may_touch(const MovingThing& thing, const MovingRules& rules, double after_s, const Vec3& center,
               double radius_m) {
  const double later_s = std::max(0.0, after_s);
  const double grown_m = thing.position_sigma_m + later_s * (thing.velocity_sigma_mps + rules.growth_mps);
  const Vec3 offset = center - thing.position - after_s * thing.velocity;
  const double thing_radius_m = thing.half_size_m.head<2>().norm();
  const double across_m = std::max(0.0, offset.head<2>().norm() - thing_radius_m - grown_m);
  const double above_m = std::max(0.0, std::abs(offset.z()) - thing.half_size_m.z() - grown_m);
  return std::hypot(across_m, above_m) < radius_m;
}

TimedLine timed_line(const Trajectory& trajectory, double from_arc_m) {
  TimedLine out{{trajectory.position_at_arc(from_arc_m)}, {0.0}};
  const double dt_s = trajectory.dt_s();
  double begun_s = 0.0;
  for (std::size_t i = 0; i < trajectory.points().size(); ++i) {
    const double time_s = static_cast<double>(i) * dt_s, arc_m = trajectory.arc_at(time_s);
    if (arc_m <= from_arc_m) {
      const double step_m = trajectory.arc_at(time_s + dt_s) - arc_m;
      begun_s = time_s + (step_m > 0.0 ? std::min(1.0, (from_arc_m - arc_m) / step_m) * dt_s : 0.0);
      continue;
    }
    out.points.push_back(trajectory.points()[i]);
    out.times_s.push_back(time_s - begun_s);
  }
  return out;
}

std::optional<Meeting> first_meeting(const Sightings& sightings, const TimedLine& line, base::StampNs begin_ns,
                                     double radius_m) {
  const double age_s = base::to_seconds(begin_ns - sightings.stamp_ns);
  double arc_m = 0.0;
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const std::size_t next = std::min(i + 1, line.points.size() - 1);
    TimedPiece piece{line.points[i], line.points[next], line.times_s[i] + age_s, line.times_s[next] + age_s};
    // At the end of its line the vehicle rests, and things may still come.
    if (next == i) piece.to_s = std::max(piece.from_s, sightings.rules.horizon_s);
    if (piece.from_s > sightings.rules.horizon_s) break;
    std::optional<Meeting> first;
    for (const MovingThing& thing : sightings.things) {
      const auto share = meeting_on(piece, thing, sightings.rules, radius_m);
      const double after_s = piece.from_s + share.value_or(0.0) * (piece.to_s - piece.from_s) - age_s;
      if (!share || (first && after_s >= first->after_s)) continue;
      const Vec3 way = *share * (piece.to - piece.from);
      first = Meeting{arc_m + way.norm(), after_s, piece.from + way, thing.id};
    }
    if (first) return first;
    arc_m += (piece.to - piece.from).norm();
  }
  return std::nullopt;
}

std::optional<double> first_touch_m(const std::vector<Vec3>& line, double radius_m,
                                    const std::vector<geometry::Index3>& voxels, double resolution_m) {
  double arc_m = 0.0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Segment piece{line[i], line[std::min(i + 1, line.size() - 1)]};
    double first = 2.0;
    for (const geometry::Index3& voxel : voxels) {
      const Vec3 center = geometry::center_of(voxel, resolution_m), half = Vec3::Constant(0.5 * resolution_m);
      const double t = first_parameter_within(piece, {center - half, center + half}, radius_m);
      if (t >= 0.0) first = std::min(first, t);
    }
    if (first <= 1.0) return arc_m + first * piece.length();
    arc_m += piece.length();
  }
  return std::nullopt;
}

}  // namespace voxnav::planning
