// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/avoidance_climb.hpp"

namespace voxnav_simulation {

AvoidanceClimb::AvoidanceClimb(const AvoidanceConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)),
      random_(seed, 0x636c696d6200),
      until_next_s_(random_.exponential(config_.interval_s)) {}

void AvoidanceClimb::step(double dt_s, double z_m, const HasRoom& has_room) {
  if (!config_.is_enabled) return;
  if (floor_m_) {
    remaining_s_ -= dt_s;
    if (remaining_s_ < 0) *floor_m_ -= config_.descent_mps * dt_s;
    if (*floor_m_ <= begin_m_) floor_m_.reset();
    return;
  }
  until_next_s_ -= dt_s;
  if (until_next_s_ > 0) return;
  until_next_s_ = random_.exponential(config_.interval_s);
  if (!has_room()) return;
  begin_m_ = z_m;
  floor_m_ = z_m + config_.correction_m;
  remaining_s_ = config_.duration_s;
}

}  // namespace voxnav_simulation
