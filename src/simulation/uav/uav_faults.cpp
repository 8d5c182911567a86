// SPDX-License-Identifier: BSD-3-Clause
// What the simulated vehicle does without being told.
#include "voxnav_simulation/uav.hpp"

namespace voxnav_simulation {
namespace {

constexpr std::int64_t kBumperPeriod_ns = 50'000'000;
constexpr std::int64_t kSectorsTimeout_ns = 1'000'000'000;
/// Room above the vehicle is looked for in steps of this height.
constexpr double kRoomStep_m = 0.5;

}  // namespace

/// Lets happen what nobody has commanded. Nothing of it happens during take-off and landing.
void Uav::meet_faults() {
  if (phase_ != FlightPhase::kFlying) {
    climb_.end();
    is_repelled_ = false;
  } else {
    if (const auto jump = resets_.step(kStep_s)) {
      jump_ += *jump;
      ++estimator_iteration_;
      tracker_.shift(*jump);
      response_.shift(*jump);
      climb_.shift(jump->z());
    }
    climb_.step(kStep_s, tracker_.state().position.z(), [this] { return has_room_above(); });
    if (bumper_.is_enabled() && stamp_ns_ % kBumperPeriod_ns == 0) meet_obstacles();
  }
  tracker_.set_floor(climb_.floor_m(), climb_.speed_ratio());
}

/// Another UAV only flies where there is room for both: above the vehicle, and above where it will be soon.
bool Uav::has_room_above() const {
  const Vec3 ahead = truth_.velocity * avoidance_.speed_ratio * avoidance_.duration_s;
  for (int step = 1; step * kRoomStep_m <= avoidance_.correction_m + kRoomStep_m; ++step) {
    const double up_m = step * kRoomStep_m;
    for (const double share : {0.0, 0.5, 1.0}) {
      const Vec3 p = truth_.pose.translation() + share * Vec3(ahead.x(), ahead.y(), 0) + Vec3(0, 0, up_m);
      if (sensed_world_.clearance(p, avoidance_.headroom_m, stamp_ns_) < avoidance_.headroom_m) return false;
    }
  }
  return true;
}

/// Returns how the bumper pushes the vehicle now.
std::optional<Vec3> Uav::push() const {
  if (bumper_.heeds_sectors()) {
    return bumper_.push(sectors_->ranges, voxnav::geometry::yaw_of(estimate_.pose), tracker_.limits());
  }
  const auto range = [this](const Vec3& direction, double max_m) {
    return sensed_world_.range(truth_.pose.translation(), direction, max_m, stamp_ns_);
  };
  return bumper_.push(range, voxnav::geometry::yaw_of(truth_.pose), tracker_.limits());
}

/// Flies away from obstacles that are too near, as long as they are, whatever was commanded. Without messages of
/// sectors everything stays as it was, so that a vehicle that was being repelled takes no commands any more.
void Uav::meet_obstacles() {
  const bool is_heard = sectors_ && stamp_ns_ - sectors_->stamp_ns <= kSectorsTimeout_ns;
  if (is_in_emergency() || (bumper_.heeds_sectors() && !is_heard)) return;
  const auto way = push();
  is_repelled_ = way.has_value();
  if (way) tracker_.go_to({estimate_.pose.translation() + *way, tracker_.state().heading_rad});
}

}  // namespace voxnav_simulation
