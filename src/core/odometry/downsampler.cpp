// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "odometry/point_map.hpp"

namespace voxnav::odometry {

VoxelKey key_of(const Vec3f& point, float inverse_size) {
  constexpr float kLimit = 1 << 20;
  VoxelKey key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float cell = std::floor(point[axis] * inverse_size);
    if (!(cell >= -kLimit && cell < kLimit)) return kNoKey;
    key = (key << 21) | static_cast<VoxelKey>(static_cast<std::int32_t>(cell) + (1 << 20));
  }
  return key;
}

void Downsampler::run(const std::vector<Vec3f>& points, double voxel_size_m, std::vector<Vec3f>* out) {
  voxels_.clear();
  out->clear();
  const auto inverse_size = static_cast<float>(1.0 / voxel_size_m);
  for (const Vec3f& p : points) {
    const VoxelKey key = key_of(p, inverse_size);
    if (key == kNoKey) continue;
    const std::size_t num_met = voxels_.size();
    if (voxels_.number_of(key) == num_met) out->push_back(p);
  }
}

}  // namespace voxnav::odometry
