// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/imu_model.hpp"

#include <cmath>

namespace voxnav_simulation {

ImuModel::ImuModel(const ImuConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)),
      random_(seed, 0x696d7500),
      gyro_bias_(normal(config_.gyro_bias)),
      accel_bias_(normal(config_.accel_bias)) {}

Vec3 ImuModel::normal(double sigma) {
  const double x = random_.normal();
  const double y = random_.normal();
  return sigma * Vec3(x, y, random_.normal());
}

void ImuModel::corrupt(double dt_s, ImuReading* sample) {
  gyro_bias_ += normal(config_.gyro_bias_walk * std::sqrt(dt_s));
  accel_bias_ += normal(config_.accel_bias_walk * std::sqrt(dt_s));
  sample->gyro += gyro_bias_ + normal(config_.gyro_noise / std::sqrt(dt_s));
  sample->accel += accel_bias_ + normal(config_.accel_noise / std::sqrt(dt_s));
}

}  // namespace voxnav_simulation
