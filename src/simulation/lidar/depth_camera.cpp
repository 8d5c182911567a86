// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/depth_camera.hpp"

#include <cmath>

#include "sensor_mount.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

std::vector<std::string> DepthCameraConfig::problems() const {
  std::vector<std::string> out;
  if (min_range_m >= max_range_m) out.emplace_back("min_range_m must be below max_range_m");
  return out;
}

Pose DepthCameraConfig::T_B_C() const {
  Pose T_F_C = Pose::Identity();  // F: axes forward, left, up
  T_F_C.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return sensor_mount(mount_position_m, mount_rpy_rad) * T_F_C;
}

voxnav::cloud::CameraModel DepthCameraConfig::camera() const {
  return {static_cast<std::uint32_t>(width),
          static_cast<std::uint32_t>(height),
          0.5 * width / std::tan(0.5 * horizontal_fov_rad),
          0.5 * height / std::tan(0.5 * vertical_fov_rad),
          0.5 * (width - 1),
          0.5 * (height - 1)};
}

DepthCameraModel::DepthCameraModel(const DepthCameraConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)), seed_(mix_bits(seed)) {
  const voxnav::cloud::CameraModel camera = config_.camera();
  for (int v = 0; v < config_.height; ++v) {
    for (int u = 0; u < config_.width; ++u) {
      const Vec3 along((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      directions_C_.emplace_back(along.normalized().cast<float>());
    }
  }
}

DepthPixels DepthCameraModel::image(const Scene& scene, const Pose& T_W_C, std::uint64_t index) const {
  const Eigen::Matrix3f R = T_W_C.linear().cast<float>();
  std::vector<Vec3f> directions_W;
  directions_W.reserve(directions_C_.size());
  for (const Vec3f& direction : directions_C_) directions_W.emplace_back(R * direction);
  std::vector<Hit> hits(directions_W.size());
  // Beyond the greatest depth lie ranges towards the corners that are longer than it.
  const auto reach_m = static_cast<float>(2.0 * config_.max_range_m);
  scene.cast(T_W_C.translation().cast<float>(), directions_W.data(), directions_W.size(), reach_m, hits.data(),
             static_cast<StampNs>(index) * std::llround(1e9 / config_.rate_hz));
  Rng random(seed_, index);
  DepthPixels out(hits.size(), 0.0F);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const double noise = random.normal(), luck = random.uniform();
    if (!hits[i].is_hit() || luck < config_.dropout_ratio) continue;
    const double depth_m = static_cast<double>(hits[i].range_m) * static_cast<double>(directions_C_[i].z());
    const double measured_m = depth_m + noise * config_.noise_per_m * depth_m * depth_m;
    if (measured_m >= config_.min_range_m && measured_m <= config_.max_range_m) out[i] = static_cast<float>(measured_m);
  }
  return out;
}

}  // namespace voxnav_simulation
