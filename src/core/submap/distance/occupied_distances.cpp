// SPDX-License-Identifier: BSD-3-Clause
#include "submap/distance/occupied_distances.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::submap {
namespace {

using containers::VoxelState;

/// Returns the number of voxels along x from bit `bit` to the nearest set bit of a row that is not empty.
int steps_along_x(std::uint32_t row, int bit) {
  constexpr int kNone = 1 << 10;
  const std::uint32_t ahead = row >> bit, behind = row & ((2u << bit) - 1u);
  return std::min(ahead != 0 ? __builtin_ctz(ahead) : kNone, behind != 0 ? bit - (31 - __builtin_clz(behind)) : kNone);
}

/// Returns the squared distance in voxels to the nearest free voxel at most `reach` away on each axis; 0 if there is
/// none.
int squared_to_free(const ContentWindow& window, const geometry::Index3& voxel, int reach) {
  const int bit = voxel.x + ContentWindow::kHalo;
  const std::uint32_t in_reach = (2u << (bit + reach)) - (1u << (bit - reach));
  int best = 0;
  for (int dz = -reach; dz <= reach; ++dz) {
    for (int dy = -reach; dy <= reach; ++dy) {
      const std::uint32_t free = window.free(voxel.y + dy, voxel.z + dz) & in_reach;
      if (free == 0) continue;
      const int dx = steps_along_x(free, bit);
      const int squared = dx * dx + dy * dy + dz * dz;
      if (best == 0 || squared < best) best = squared;
    }
  }
  return best;
}

bool is_enclosed(const ContentWindow& window, const geometry::Index3& voxel) {
  const auto is_occupied = [&](int dx, int dy, int dz) {
    return window.state(voxel.x + dx, voxel.y + dy, voxel.z + dz) == VoxelState::kOccupied;
  };
  return is_occupied(1, 0, 0) && is_occupied(-1, 0, 0) && is_occupied(0, 1, 0) && is_occupied(0, -1, 0) &&
         is_occupied(0, 0, 1) && is_occupied(0, 0, -1);
}

}  // namespace

float occupied_distance(const ContentWindow& window, std::size_t i, const SurfaceNormal& normal, float band) {
  constexpr float kDeepest = -0.1f;
  const geometry::Index3& voxel = window.voxels()[i];
  const float to_plane = -normal.normal.dot(window.mean(i));
  if (normal.quality >= kPlanarQuality) return to_plane;
  if (normal.quality >= kOneSidedQuality) return std::min(to_plane, kDeepest);
  int squared = squared_to_free(window, voxel, 1);
  // A surface in unknown space may be one voxel thick; only a voxel that is enclosed by occupied ones is known to lie
  // deep inside. Free voxels beyond the band need not be searched, as distances end there.
  if (squared == 0) {
    const int farthest = static_cast<int>(std::ceil(band + 0.5f)) - 1;
    squared = is_enclosed(window, voxel) ? squared_to_free(window, voxel, farthest) : 1;
  }
  if (squared == 0) return -band;
  return std::max(0.5f - std::sqrt(static_cast<float>(squared)), -band);
}

}  // namespace voxnav::submap
