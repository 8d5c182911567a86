// SPDX-License-Identifier: BSD-3-Clause
#include "planning/other_uavs.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace voxnav::planning {
namespace {

using base::StampNs;
using geometry::Vec3;

/// Balls of a track are this far apart in time.
constexpr double kTrackStep_s = 0.2;
/// A vehicle may be this much earlier at a place than its speed tells, or later by this and by the ratio: it
/// accelerates, goes around things, and replans.
constexpr double kSlack_s = 1.0;
constexpr double kLateRatio = 2.5;

}  // namespace

void require_valid(const OtherUav& other) {
  const double numbers[] = {other.radius_m, other.growth_mps, other.late_growth_mps, other.max_growth_m,
                            other.horizon_s};
  bool is_good = !other.places.empty() && other.step_s > 0.0 && std::isfinite(other.step_s);
  for (const double number : numbers) is_good = is_good && std::isfinite(number) && number >= 0.0;
  for (const Vec3& place : other.places) is_good = is_good && place.allFinite();
  if (!is_good) throw std::invalid_argument("the other UAV " + other.name + " has no places, or a bad number");
}

StampNs horizon_ns(const OtherUav& other) { return other.seen_ns + base::from_seconds(other.horizon_s); }

Vec3 place_at(const OtherUav& other, StampNs at_ns) {
  const double along = base::to_seconds(at_ns - other.stamp_ns) / other.step_s;
  const auto last = static_cast<double>(other.places.size() - 1);
  if (along <= 0.0) return other.places.front();
  if (along >= last) return other.places.back();
  const auto i = static_cast<std::size_t>(along);
  return other.places[i] + (along - static_cast<double>(i)) * (other.places[i + 1] - other.places[i]);
}

double radius_at(const OtherUav& other, StampNs at_ns) {
  const double age_s = std::max(0.0, base::to_seconds(at_ns - other.stamp_ns));
  const double late_s = std::max(0.0, age_s - other.step_s * static_cast<double>(other.places.size() - 1));
  return other.radius_m + std::min(other.max_growth_m, age_s * other.growth_mps + late_s * other.late_growth_mps);
}

bool may_touch(const OtherUav& other, StampNs at_ns, const Vec3& center, double radius_m) {
  return (center - place_at(other, at_ns)).norm() < radius_m + radius_at(other, at_ns);
}

StampNs Arrival::earliest_ns(const Vec3& place) const {
  return now_ns + base::from_seconds(std::max(0.0, (place - vehicle).norm() / speed_mps - kSlack_s));
}

StampNs Arrival::latest_ns(const Vec3& place) const {
  return now_ns + base::from_seconds(kLateRatio * (place - vehicle).norm() / speed_mps + kSlack_s);
}

OtherUavTrack::OtherUavTrack(const OtherUav& other, StampNs now_ns, double clearance_m) {
  for (StampNs at_ns = now_ns; at_ns <= horizon_ns(other); at_ns += base::from_seconds(kTrackStep_s)) {
    add({at_ns, place_at(other, at_ns), radius_at(other, at_ns) + clearance_m});
  }
}

void OtherUavTrack::add(const Ball& ball) {
  const Vec3 half = Vec3::Constant(ball.radius_m);
  const geometry::Aabb around{ball.center - half, ball.center + half};
  if (balls_.empty()) {
    box_ = around;
  } else {
    box_ = {box_.min.cwiseMin(around.min), box_.max.cwiseMax(around.max)};
  }
  balls_.push_back(ball);
}

OtherUavTrack OtherUavTrack::within(const geometry::Aabb& box) const {
  OtherUavTrack out;
  for (const Ball& ball : balls_) {
    const Vec3 nearest = ball.center.cwiseMax(box.min).cwiseMin(box.max);
    if ((nearest - ball.center).norm() < ball.radius_m) out.add(ball);
  }
  return out;
}

bool OtherUavTrack::may_meet(const Arrival& arrival, const Vec3& place) const {
  const StampNs earliest_ns = arrival.earliest_ns(place), latest_ns = arrival.latest_ns(place);
  return std::any_of(balls_.begin(), balls_.end(), [&](const Ball& ball) {
    return ball.at_ns >= earliest_ns && ball.at_ns <= latest_ns &&
           (place - ball.center).squaredNorm() < ball.radius_m * ball.radius_m;
  });
}

}  // namespace voxnav::planning
