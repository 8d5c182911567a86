// SPDX-License-Identifier: BSD-3-Clause
#include "submap/distance/unknown_distances.hpp"

#include <cmath>

namespace voxnav::submap {
namespace {

using geometry::kBlockSide;
using geometry::Vec3f;

constexpr int kHalo = ContentWindow::kHalo;

float signed_distance(const Vec3f& from_voxel, const Vec3f& mean, const SurfaceNormal& normal, float squared) {
  if (normal.quality >= kSolidQuality) return normal.normal.dot(from_voxel - mean);
  // Behind a voxel without a free side lies more of the same solid, while all around a thin thing is outside.
  const float distance = std::sqrt(squared);
  return normal.quality == 0.f ? -distance : distance;
}

}  // namespace

void UnknownDistances::list_unknown(const ContentWindow& window) {
  unknown_.fill(0);
  for (int z = -1; z <= kBlockSide; ++z) {
    for (int y = -1; y <= kBlockSide; ++y) {
      unknown_[row_at(y, z)] = kTableBits & ~(window.free(y, z) | window.occupied(y, z));
    }
  }
}

void UnknownDistances::find(const ContentWindow& window) {
  list_unknown(window);
  squared_.fill(kFar);
  near_table_.clear();
  for (std::size_t i = 0; i < window.voxels().size(); ++i) {
    if (!is_in_table(window.voxels()[i], 1)) continue;
    spread(window.voxels()[i], window.mean(i), static_cast<std::uint16_t>(near_table_.size()));
    near_table_.push_back(static_cast<std::uint16_t>(i));
  }
}

/// Updates the unknown voxels among the 26 neighbours of an occupied voxel, if its surface point is nearer to them.
void UnknownDistances::spread(const geometry::Index3& voxel, const Vec3f& mean, std::uint16_t number) {
  const std::uint32_t beside = 7u << (voxel.x - 1 + kHalo);
  for (int row = 0; row < 9; ++row) {
    const int y = voxel.y + row % 3 - 1;
    const int z = voxel.z + row / 3 - 1;
    const std::uint32_t unknown = unknown_[row_at(y, z)] & beside;
    if (unknown == 0) continue;
    const float dy = static_cast<float>(y - voxel.y) - mean.y();
    const float dz = static_cast<float>(z - voxel.z) - mean.z();
    const float across = dy * dy + dz * dz;
    kernels::for_each_bit(unknown, [&](int bit) {
      const int x = bit - kHalo;
      const float dx = static_cast<float>(x - voxel.x) - mean.x();
      const float squared = dx * dx + across;
      const std::size_t i = table_at(x, y, z);
      if (squared >= squared_[i]) return;
      squared_[i] = squared;
      nearest_[i] = number;
    });
  }
}

void UnknownDistances::write(const ContentWindow& window, const std::vector<SurfaceNormal>& normals,
                             DistanceBlock* out) const {
  for (int z = -1; z <= kBlockSide; ++z) {
    for (int y = -1; y <= kBlockSide; ++y) {
      kernels::for_each_bit(unknown_[row_at(y, z)], [&](int bit) {
        const int x = bit - kHalo;
        const std::size_t i = table_at(x, y, z);
        if (squared_[i] == kFar) return;
        const std::uint16_t nearest = near_table_[nearest_[i]];
        const geometry::Index3& voxel = window.voxels()[nearest];
        const Vec3f from_voxel(x - voxel.x, y - voxel.y, z - voxel.z);
        out->set(x, y, z, signed_distance(from_voxel, window.mean(nearest), normals[nearest_[i]], squared_[i]));
      });
    }
  }
}

}  // namespace voxnav::submap
