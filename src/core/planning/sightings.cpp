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

/// Returns the share of a piece that is flown before something is touched; nothing if it is not. `touches` is asked for
/// times after the stamp of the things up to a horizon, and for places of the vehicle.
template <class Touches>
std::optional<double> meeting_on(const TimedPiece& piece, double horizon_s, const Touches& touches) {
  const int steps = std::max(1, static_cast<int>(std::ceil((piece.to_s - piece.from_s) / kStep_s)));
  for (int i = 0; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    const double after_s = piece.from_s + share * (piece.to_s - piece.from_s);
    if (after_s > horizon_s) return std::nullopt;
    if (touches(after_s, piece.from + share * (piece.to - piece.from))) return share;
  }
  return std::nullopt;
}

/// How far ahead anything is predicted, after the stamp of the things.
double longest_horizon_s(const Sightings& sightings) {
  double out = sightings.things.empty() ? 0.0 : sightings.rules.horizon_s;
  if (sightings.others == nullptr) return out;
  for (const OtherUav& other : *sightings.others) {
    out = std::max(out, base::to_seconds(horizon_ns(other) - sightings.stamp_ns));
  }
  return out;
}

/// Finds the first meeting on a line, piece by piece.
class MeetingSearch {
 public:
  MeetingSearch(const Sightings& sightings, double age_s, double radius_m)
      : sightings_(sightings), age_s_(age_s), radius_m_(radius_m) {}

  /// @param arc_m  length of the line before the piece
  std::optional<Meeting> on(const TimedPiece& piece, double arc_m) const {
    std::optional<Meeting> first;
    const auto offer = [&](std::optional<double> share, std::uint32_t id, const std::string& name) {
      const double after_s = piece.from_s + share.value_or(0.0) * (piece.to_s - piece.from_s) - age_s_;
      if (!share || (first && after_s >= first->after_s)) return;
      const Vec3 way = *share * (piece.to - piece.from);
      first = Meeting{arc_m + way.norm(), after_s, piece.from + way, id, name};
    };
    for (const MovingThing& thing : sightings_.things) offer(share_to(thing, piece), thing.id, {});
    if (sightings_.others == nullptr) return first;
    for (const OtherUav& other : *sightings_.others) offer(share_to(other, piece), 0, other.name);
    return first;
  }

 private:
  std::optional<double> share_to(const MovingThing& thing, const TimedPiece& piece) const {
    return meeting_on(piece, sightings_.rules.horizon_s, [&](double after_s, const Vec3& place) {
      return may_touch(thing, sightings_.rules, after_s, place, radius_m_);
    });
  }
  std::optional<double> share_to(const OtherUav& other, const TimedPiece& piece) const {
    const double horizon_s = base::to_seconds(horizon_ns(other) - sightings_.stamp_ns);
    return meeting_on(piece, horizon_s, [&](double after_s, const Vec3& place) {
      return may_touch(other, sightings_.stamp_ns + base::from_seconds(after_s), place, radius_m_);
    });
  }

  const Sightings& sightings_;
  double age_s_;
  double radius_m_;
};

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
  const double horizon_s = longest_horizon_s(sightings);
  const MeetingSearch search(sightings, age_s, radius_m);
  double arc_m = 0.0;
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const std::size_t next = std::min(i + 1, line.points.size() - 1);
    TimedPiece piece{line.points[i], line.points[next], line.times_s[i] + age_s, line.times_s[next] + age_s};
    // At the end of its line the vehicle rests, and things may still come.
    if (next == i) piece.to_s = std::max(piece.from_s, horizon_s);
    if (piece.from_s > horizon_s) break;
    if (auto first = search.on(piece, arc_m)) return first;
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
