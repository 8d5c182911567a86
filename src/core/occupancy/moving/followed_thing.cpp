// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/moving/followed_thing.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::occupancy {
namespace {

constexpr std::size_t kMaxSightings = 64;
/// A motion is fitted to the sightings of this time.
constexpr double kFit_s = 0.8;
constexpr std::size_t kFewestToFit = 3;
/// Hits are looked for this far around the expected box; farther while its velocity is not known.
constexpr double kGate_m = 0.5;
constexpr double kUnknownSpeed_mps = 5.0;
/// The box of a thing may grow by this from one sweep to the next, because more of it is seen.
constexpr double kGrowth_m = 0.8;
/// Sightings that agree with a motion differ from it by less than this, and by less than this share of the way.
constexpr double kAgreement_m = 0.2;
constexpr double kAgreementShare = 0.2;
/// A thing has left a place when there is this much room between its boxes.
constexpr double kGap_m = 0.3;
/// A thing that moves relative to the vehicle by less than this share of the vehicle's velocity keeps to the vehicle.
constexpr double kOwnShare = 0.5;
/// Returns of a thing in a sweep, on average, half of its least height, and that height as a share of its width.
constexpr int kReturns = 5;
constexpr double kLeastHeight_m = 0.05;
constexpr double kFlatShare = 0.25;
/// A thing that stays within this distance stands.
constexpr double kStands_m = 0.4;
/// Least standard deviations: what is seen of a thing changes while it moves.
constexpr double kLeastSigma_m = 0.1;
constexpr double kLeastSigma_mps = 0.1;

geometry::Vec3 size_of(const geometry::Aabb& box) { return box.max - box.min; }

geometry::Aabb shifted(const geometry::Aabb& box, const geometry::Vec3& by) { return {box.min + by, box.max + by}; }

}  // namespace

FollowedThing::FollowedThing(std::uint32_t track_id, base::StampNs stamp_ns, const HitCluster& cluster)
    : id(track_id), rest_center_(cluster.center), moved_ns_(stamp_ns) {
  see(stamp_ns, cluster);
}

geometry::Vec3 FollowedThing::expected_center(base::StampNs stamp_ns) const {
  return sightings_.back().center + unseen_s(stamp_ns) * fit_.velocity;
}

geometry::Aabb FollowedThing::expected_box(base::StampNs stamp_ns) const {
  const double later_s = unseen_s(stamp_ns);
  const bool is_fitted = fit_.num_sightings >= kFewestToFit;
  const double gate_m = kGate_m + later_s * (is_fitted ? 2.0 * fit_.velocity_sigma_mps : kUnknownSpeed_mps);
  return shifted(sightings_.back().box, later_s * fit_.velocity).padded(gate_m);
}

bool FollowedThing::may_have(const geometry::Aabb& box, double max_size_m) const {
  const geometry::Vec3 now = size_of(box), before = size_of(sightings_.back().box);
  return (now.array() <= max_size_m).all() && (now.array() <= before.array() + kGrowth_m).all();
}

void FollowedThing::see(base::StampNs stamp_ns, const HitCluster& cluster) {
  sightings_.push_back({stamp_ns, cluster.center, cluster.box, cluster.num_returns});
  if (sightings_.size() > kMaxSightings) sightings_.pop_front();
  if ((cluster.center - rest_center_).norm() > kStands_m) {
    rest_center_ = cluster.center;
    moved_ns_ = stamp_ns;
  }
  // The line of least squares through the sightings of a short time; times are relative to the last one.
  MotionFit fit;
  double time_s = 0.0, time_sq = 0.0;
  geometry::Vec3 mean = geometry::Vec3::Zero(), moment = geometry::Vec3::Zero();
  const auto begin = std::find_if(sightings_.begin(), sightings_.end(),
                                  [&](const Sighting& s) { return base::to_seconds(stamp_ns - s.stamp_ns) <= kFit_s; });
  const auto count = static_cast<double>(sightings_.end() - begin);
  for (auto s = begin; s != sightings_.end(); ++s) {
    time_s += base::to_seconds(s->stamp_ns - stamp_ns) / count;
    mean += s->center / count;
  }
  for (auto s = begin; s != sightings_.end(); ++s) {
    const double later_s = base::to_seconds(s->stamp_ns - stamp_ns) - time_s;
    time_sq += later_s * later_s;
    moment += later_s * (s->center - mean);
  }
  fit.num_sightings = static_cast<std::size_t>(sightings_.end() - begin);
  if (fit.num_sightings >= kFewestToFit && time_sq > 0.0) fit.velocity = moment / time_sq;
  fit.center = mean - time_s * fit.velocity;
  double sum_sq = 0.0;
  for (auto s = begin; s != sightings_.end(); ++s) {
    const double later_s = base::to_seconds(s->stamp_ns - stamp_ns);
    sum_sq += (s->center - fit.center - later_s * fit.velocity).squaredNorm();
  }
  fit.rms_m = std::sqrt(sum_sq / count);
  fit.velocity_sigma_mps =
      std::max(kLeastSigma_mps, time_sq > 0.0 ? fit.rms_m / std::sqrt(time_sq) : kUnknownSpeed_mps);
  fit_ = fit;
}

bool FollowedThing::agrees_to_move(const MovingThingsConfig& config, const geometry::Vec3& vehicle_velocity) const {
  if (fit_.num_sightings < static_cast<std::size_t>(config.min_sweeps)) return false;
  const double speed = fit_.velocity.norm();
  if (speed < config.min_speed_mps || speed > config.max_speed_mps || fit_.rms_m > kAgreement_m) return false;
  if (!is_body()) return false;
  if ((fit_.velocity - vehicle_velocity).norm() < kOwnShare * vehicle_velocity.norm()) return false;
  return std::any_of(sightings_.begin(), sightings_.end(), [&](const Sighting& earlier) { return has_left(earlier); });
}

/// Whether enough was seen of it, and it is no flat piece of ground: at grazing angles hits on the ground wander.
bool FollowedThing::is_body() const {
  int num_returns = 0;
  const auto recent = static_cast<std::ptrdiff_t>(fit_.num_sightings);
  for (auto s = sightings_.end() - recent; s != sightings_.end(); ++s) num_returns += s->num_returns;
  const geometry::Vec3 half = half_size_m();
  return num_returns >= kReturns * static_cast<int>(fit_.num_sightings) &&
         half.z() >= std::max(kLeastHeight_m, kFlatShare * half.head<2>().maxCoeff());
}

geometry::Vec3 FollowedThing::half_size_m() const {
  geometry::Vec3 out = geometry::Vec3::Zero();
  const std::size_t recent = std::min(sightings_.size(), fit_.num_sightings);
  for (auto s = sightings_.end() - static_cast<std::ptrdiff_t>(recent); s != sightings_.end(); ++s) {
    out = out.cwiseMax(0.5 * size_of(s->box));
  }
  return out;
}

bool FollowedThing::has_left(const Sighting& earlier) const {
  const Sighting& now = sightings_.back();
  if (earlier.box.padded(kGap_m).intersects(now.box)) return false;
  const geometry::Vec3 way = now.center - earlier.center;
  const geometry::Vec3 expected = base::to_seconds(now.stamp_ns - earlier.stamp_ns) * fit_.velocity;
  return (way - expected).norm() <= kAgreementShare * way.norm() && fit_.rms_m <= kAgreementShare * way.norm();
}

bool FollowedThing::stands(base::StampNs stamp_ns, double after_s) const {
  return base::to_seconds(stamp_ns - moved_ns_) > after_s;
}

MovingThing FollowedThing::thing_at(base::StampNs stamp_ns) const {
  MovingThing out;
  const double later_s = unseen_s(stamp_ns);
  const geometry::Aabb& box = sightings_.back().box;
  out.id = id;
  out.position = 0.5 * (box.min + box.max) + later_s * fit_.velocity;
  out.velocity = fit_.velocity;
  out.half_size_m = half_size_m();
  out.velocity_sigma_mps = fit_.velocity_sigma_mps;
  out.position_sigma_m = std::max(kLeastSigma_m, fit_.rms_m) + later_s * fit_.velocity_sigma_mps;
  return out;
}

}  // namespace voxnav::occupancy
