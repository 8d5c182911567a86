// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/tracking_response.hpp"

#include <cmath>

namespace voxnav_simulation {
namespace {

constexpr double kMaxDisturbance = 2.0;  ///< m/s^2, that the controller learns at most, per axis
constexpr double kMaxCommand = 17.0;     ///< m/s^2: a tilt of 60 degrees, beyond which the control manager lands

}  // namespace

std::vector<std::string> TrackingConfig::problems() const {
  // Routh's criterion for the loop of position, velocity and the lag of tilt or thrust, to which the delay is added.
  const auto is_stable = [this](double kp, double kv, double lag_s) { return kv > kp * (lag_s + delay_s); };
  if (is_stable(horizontal_position_gain, horizontal_velocity_gain, tilt_time_s) &&
      is_stable(vertical_position_gain, vertical_velocity_gain, thrust_time_s)) {
    return {};
  }
  return {"the controller would be unstable: lower the position gain, or the delay and the time constants"};
}

TrackingResponse::TrackingResponse(const TrackingConfig& config, bool is_exact)
    : config_(voxnav::base::checked(config)), is_exact_(is_exact) {}

void TrackingResponse::reset(const KinematicState& reference) {
  position_ = reference.position;
  velocity_ = reference.velocity;
  thrust_ = resistance_ = disturbance_ = Vec3::Zero();
  delayed_.clear();
}

void TrackingResponse::shift(const Vec3& jump) { position_ += jump; }

Vec3 TrackingResponse::command(const KinematicState& reference, double dt_s) {
  const TrackingConfig& c = config_;
  const Vec3 kp(c.horizontal_position_gain, c.horizontal_position_gain, c.vertical_position_gain);
  const Vec3 kv(c.horizontal_velocity_gain, c.horizontal_velocity_gain, c.vertical_velocity_gain);
  const Vec3 away = reference.position - position_, slow = reference.velocity - velocity_;
  disturbance_ += c.disturbance_gain * dt_s * away;
  disturbance_ = disturbance_.cwiseMax(-kMaxDisturbance).cwiseMin(kMaxDisturbance);
  Vec3 out = reference.acceleration + kp.cwiseProduct(away) + kv.cwiseProduct(slow) + disturbance_;
  if (out.norm() > kMaxCommand) out *= kMaxCommand / out.norm();
  return out;
}

void TrackingResponse::step(const KinematicState& reference, const Vec3& air_velocity, double dt_s) {
  delayed_.push_back(command(reference, dt_s));
  if (is_exact_) {
    thrust_ = delayed_.back();
    delayed_.clear();
  } else if (delayed_.size() > static_cast<std::size_t>(std::llround(config_.delay_s / dt_s))) {
    const double tilted = 1.0 - std::exp(-dt_s / config_.tilt_time_s);
    const double spun = 1.0 - std::exp(-dt_s / config_.thrust_time_s);
    thrust_ += Vec3(tilted, tilted, spun).cwiseProduct(delayed_.front() - thrust_);
    delayed_.pop_front();
  }
  resistance_ = config_.drag * (air_velocity - velocity_);
  const Vec3 before = velocity_;
  velocity_ += acceleration() * dt_s;
  position_ += 0.5 * (before + velocity_) * dt_s;
}

}  // namespace voxnav_simulation
